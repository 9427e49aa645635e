"""Evaluation during training: greedy episodes on maps that neither training nor comparisons use."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from indoor_explorers.env.simulation.world import World

#: The first coverage that evaluations report the steps to.
T90 = 0.9


class Evaluation(NamedTuple):
    """Results of a network at one point of its training, greedy among the legal moves."""

    steps: int
    """Moves made in training by then."""
    t90: float
    """Mean steps to 90 % of the reachable cells; the budget where it was not reached."""
    t_goal: float
    """Mean steps to the goal of the training; the budget where it was not reached."""
    missed: float
    """Share of the episodes that never reached the goal."""
    score: float
    """Mean of (steps to 90 % + steps to the goal) / budget; lower is better."""


def evaluate_world(world: World, act: Callable[[], None], steps: int) -> Evaluation:
    """Fly a batch of episodes to their ends and return their mean results.

    Args:
        world: The episodes, at their beginning.
        act: Makes one move of every UAV.
        steps: Moves made in training so far.

    """
    budget = world.state.budget
    t90 = np.where(world.counted_coverage >= T90, 0, budget)
    while world.flying.any():
        act()
        t90 = np.where(world.counted_coverage >= T90, np.minimum(t90, world.state.step), t90)
    counted = world.state.base_covered if world.scenario.base.must_return else world.state.team_covered
    missed = counted < world.state.needed
    t_goal = np.where(missed, budget, world.state.step)
    score = ((t90 + t_goal) / budget).mean()
    return Evaluation(steps, float(t90.mean()), float(t_goal.mean()), float(missed.mean()), float(score))


def mean_evaluation(evaluations: Sequence[Evaluation]) -> Evaluation:
    """Return the means of the evaluations of one network on several scenarios."""
    figures = np.mean([evaluation[1:] for evaluation in evaluations], axis=0)
    return Evaluation(evaluations[0].steps, *map(float, figures))
