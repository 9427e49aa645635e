"""A library's model in training: its evaluation, greedy among the legal moves, and the record of the training."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.observations import Encoder, Observation, make_encoder
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.world import World
from indoor_explorers.learners.baselines.config import BaselineConfig
from indoor_explorers.learners.sessions.evaluation import Evaluation, evaluate_world
from indoor_explorers.learners.sessions.record import TrainingRecord, new_record
from indoor_explorers.learners.sessions.seeds import evaluation_seeds
from indoor_explorers.learners.sessions.session import Trainee, TrainingStatus

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


class BaselineRecord(TrainingRecord):
    """How a library's model in a folder was trained."""

    shape: tuple[int, int]
    """(H, W) of the scenario's maps in cells."""
    inputs: int = Field(ge=1)
    """Length of an observation."""


def baseline_record(
    learner: str,
    packages: Iterable[str],
    make_world: Callable[[Scenario, int, int], World],
    config: BaselineConfig,
    scenario: Scenario,
    seed: int,
) -> BaselineRecord:
    """Return the record of a new training.

    ``make_world`` makes a world of a scenario, a batch size and a map's index.

    Raises :class:`InputError` if ``make_world`` refuses the scenario, or there is no such observation.
    """
    briefing = make_world(config.task(scenario), 1, 0).briefing(0, 0)
    inputs = int(np.prod(make_encoder(config.recipe, briefing).space.shape or ()))
    record = new_record(learner, config, scenario, seed, ("gymnasium", *packages))
    return BaselineRecord(**vars(record), shape=briefing.shape, inputs=inputs)


class BaselineTrainee(Trainee):
    """Base of the trainees of all libraries."""

    def __init__(self, config: BaselineConfig, scenario: Scenario, seed: int) -> None:
        self.config, self._task, self._seed = config, config.task(scenario), seed

    @property
    def done(self) -> bool:
        """Tell whether the training is complete."""
        return self.steps >= self.config.total_steps

    @property
    @abstractmethod
    def loss(self) -> float:
        """The latest loss; NaN before the first one."""

    @property
    def epsilon(self) -> float | None:
        """Current probability of a random move; None for a stochastic policy."""
        return None

    @abstractmethod
    def scores(self, rows: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return action scores (B, 5), higher is better, for observations (B, D)."""

    def status(self) -> TrainingStatus:
        """Return the current status for a report."""
        return TrainingStatus(total_steps=self.config.total_steps, epsilon=self.epsilon, loss=self.loss)

    def evaluate(self) -> dict[str, int | float]:
        """Evaluate the model."""
        config, first = self.config, evaluation_seeds(self._seed)
        return evaluate(self.scores, config.recipe, self._task, config.evaluation_episodes, first, self.steps)._asdict()

    def rank(self, evaluation: Mapping[str, int | float]) -> tuple[float, ...]:
        """Return the key that evaluations are compared by: steps to the goal, then steps to 90 %."""
        return evaluation["t_goal"], evaluation["t90"]
