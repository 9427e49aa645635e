"""Evaluation during training: greedy episodes, apart from those that are learned from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.dddqn.learning.learner import Learner
from indoor_explorers.learners.dddqn.learning.vector_flight import Flock
from indoor_explorers.learners.dddqn.observation.map_prior import MapPrior


class Trial(NamedTuple):
    """How the averaged weights did at one moment of the training; the guard is off."""

    steps: int
    """Moves made in training by then."""
    t90: float
    """Mean steps to 90 % of the reachable cells, the budget where it was not reached."""
    t_goal: float
    """The same for the goal of the training."""
    missed: float
    """Share of the episodes that never reached the goal."""
    score: float
    """What the best weights have least of: the mean steps to both marks, in budgets."""


def mean_trial(trials: Sequence[Trial]) -> Trial:
    """Return the means of the trials of one moment on several scenarios."""
    figures = np.mean([trial[1:] for trial in trials], axis=0)
    return Trial(trials[0].steps, *map(float, figures))


def evaluate(learner: Learner, task: Scenario, prior: MapPrior, episodes: int, first_seed: int, steps: int) -> Trial:
    """Fly ``episodes`` episodes of the task with seeds from ``first_seed`` on, greedily by the averaged weights."""
    seeds = iter(range(first_seed, first_seed + episodes))
    flock = Flock(task, learner.config.observation, prior, episodes, lambda: next(seeds))
    world = flock.world
    reached = np.where(world.team_coverage >= 0.9, 0, world.state.budget)
    while len(flying := np.flatnonzero(~flock.over)):
        flock.observe(flying)
        action = np.full(flock.columns, 4)
        action[flying] = learner.greedy(learner.average, flock.scenes[flying], flock.moves[flying], mask=True)
        flock.step(action)
        reached = np.where(world.team_coverage >= 0.9, np.minimum(reached, world.state.step), reached)
    missed = world.state.team_covered < world.state.needed
    t_goal = np.where(missed, world.state.budget, world.state.step)
    score = ((reached + t_goal) / world.state.budget).mean()
    return Trial(steps, float(reached.mean()), float(t_goal.mean()), float(missed.mean()), float(score))
