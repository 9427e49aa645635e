"""Evaluation during training: greedy episodes, apart from those that are learned from and compared on."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.observations import Encoder, Observation, make_encoder
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.world import World

#: A network: observations (B, D) float32 in, one number for each of the five actions (B, 5) out.
Scores: TypeAlias = Callable[[NDArray[np.float32]], NDArray[np.float32]]


class Trial(NamedTuple):
    """How a network did at one moment of its training, greedy among the legal moves."""

    steps: int
    """Moves made in training by then."""
    t90: float
    """Mean steps to 90 % of the reachable cells, the budget where it was not reached."""
    t_goal: float
    """The same for the goal of the training."""
    missed: float
    """Share of the episodes that never reached the goal."""


def best_moves(scores: NDArray[np.float32], legal: Mask) -> NDArray[np.int64]:
    """Return the (B,) legal actions of highest score, the first of equals."""
    return np.asarray(np.where(legal, scores, -np.inf).argmax(axis=1))


def evaluate(
    scores: Scores, observation: Observation, task: Scenario, episodes: int, first_seed: int, steps: int
) -> Trial:
    """Fly ``episodes`` episodes of the task with seeds from ``first_seed`` on, greedily."""
    world = World(task, episodes)
    world.reset(range(first_seed, first_seed + episodes))
    encoders = _encoders(world, observation)
    rows = np.empty((episodes * task.team, *(encoders[0][0].space.shape or ())), np.float32)
    budget = world.state.budget
    reached = np.where(world.team_coverage >= 0.9, 0, budget)
    while world.flying.any():
        places, agents = np.nonzero(world.flying)
        for row, b, n in zip(rows, places.tolist(), agents.tolist(), strict=False):
            encoders[b][n].encode(world.view(b, n), row)
        actions = np.full((episodes, task.team), int(Action.STAY))
        actions[places, agents] = best_moves(scores(rows[: len(places)]), world.state.legal[places, agents])
        world.step(actions)
        reached = np.where(world.team_coverage >= 0.9, np.minimum(reached, world.state.step), reached)
    missed = world.state.team_covered < world.state.needed
    t_goal = np.where(missed, budget, world.state.step)
    return Trial(steps, float(reached.mean()), float(t_goal.mean()), float(missed.mean()))


def _encoders(world: World, observation: Observation) -> list[list[Encoder]]:
    """Return an encoder for each UAV of each episode; those without a memory are shared between episodes."""
    team = range(world.scenario.team)
    first = [make_encoder(observation, world.briefing(0, n)) for n in team]
    return [first] + [
        [first[n] if first[n].stateless else make_encoder(observation, world.briefing(b, n)) for n in team]
        for b in range(1, world.batch)
    ]
