"""Evaluation of a library's network during training: greedy among the legal moves."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.observations import Encoder, Observation, make_encoder
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.world import World
from indoor_explorers.learners.sessions.evaluation import Evaluation, evaluate_world

#: A network: maps observations (B, D) float32 to scores of the five actions (B, 5) float32.
Scores: TypeAlias = Callable[[NDArray[np.float32]], NDArray[np.float32]]


def best_moves(scores: NDArray[np.float32], legal: Mask) -> NDArray[np.int64]:
    """Return the legal actions (B,) of highest score, the first among equals."""
    return np.asarray(np.where(legal, scores, -np.inf).argmax(axis=1))


def evaluate(
    scores: Scores, observation: Observation, task: Scenario, episodes: int, first_seed: int, steps: int
) -> Evaluation:
    """Fly ``episodes`` episodes of a task and return their mean results.

    Their seeds begin at ``first_seed``; ``steps`` is the number of training moves so far.
    """
    world = World(task, episodes)
    world.reset(range(first_seed, first_seed + episodes))
    encoders = _encoders(world, observation)
    rows = np.empty((episodes * task.team, *(encoders[0][0].space.shape or ())), np.float32)

    def act() -> None:
        places, agents = np.nonzero(world.flying)
        for row, b, n in zip(rows, places.tolist(), agents.tolist(), strict=False):
            encoders[b][n].encode(world.view(b, n), row)
        actions = np.full((episodes, task.team), int(Action.STAY))
        actions[places, agents] = best_moves(scores(rows[: len(places)]), world.state.legal[places, agents])
        world.step(actions)

    return evaluate_world(world, act, steps)


def _encoders(world: World, observation: Observation) -> list[list[Encoder]]:
    """Return an encoder for each UAV of each episode; stateless ones are shared between episodes."""
    team = range(world.scenario.team)
    first = [make_encoder(observation, world.briefing(0, n)) for n in team]
    return [first] + [
        [first[n] if first[n].stateless else make_encoder(observation, world.briefing(b, n)) for n in team]
        for b in range(1, world.batch)
    ]
