"""The dueling double deep Q-network (DDDQN) of this project.

A training is a session around :class:`indoor_explorers.learners.dddqn.train.Training`.
The folder gets ``weights.safetensors`` (the averaged weights that did best in evaluation), ``training.json``
(configuration, seed, versions, commits, evaluations), ``checkpoint.safetensors`` (everything that a resumed training
needs) and ``tensorboard/``. The same seed gives the same weights, resumed or not.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.dddqn.config import TrainingConfig
from indoor_explorers.learners.dddqn.learning.learner import Learner
from indoor_explorers.learners.dddqn.learning.multi_task_flight import MultiTaskFlight
from indoor_explorers.learners.dddqn.learning.prior_fitting import collect_all, fit_prior
from indoor_explorers.learners.dddqn.learning.replay import Replay, Tick
from indoor_explorers.learners.dddqn.learning.vector_flight import VectorFlight
from indoor_explorers.learners.dddqn.network.model import arrays
from indoor_explorers.learners.dddqn.observation.layout import BLOCKED_AT
from indoor_explorers.learners.dddqn.observation.map_prior import MapPrior, no_prior, prior_arrays, prior_from
from indoor_explorers.learners.dddqn.presets import (
    ABLATION_SETTINGS,
    ABLATIONS,
    PRESETS,
    SCALING,
    SCALING_AXES,
    TEAM_ABLATIONS,
    flown,
)
from indoor_explorers.learners.dddqn.weights import write_weights
from indoor_explorers.learners.sessions.checkpoint import read_checkpoint, reporting_damage, write_checkpoint
from indoor_explorers.learners.sessions.evaluation import T90, Evaluation, evaluate_world, mean_evaluation
from indoor_explorers.learners.sessions.record import new_record
from indoor_explorers.learners.sessions.seeds import episode_seed, evaluation_seeds, prior_seeds, training_seeds
from indoor_explorers.learners.sessions.session import Session, Trainee, TrainingStatus
from indoor_explorers.learners.sessions.tensorboard import Scalars
from indoor_explorers.learners.sessions.train import TrainingMethod
from indoor_explorers.planners.toolbox.networks.tensors import WEIGHTS

__all__ = [
    "ABLATIONS",
    "ABLATION_SETTINGS",
    "PRESETS",
    "SCALING",
    "SCALING_AXES",
    "TEAM_ABLATIONS",
    "TrainingConfig",
    "flown",
    "train",
]


class Training(Trainee):
    """Train on a batch of episodes in ticks: a move of all UAVs and some updates of the network.

    In a tick the UAVs move in one thread, with the weights from the start of the tick, while the network learns from
    earlier ticks in another thread. Their results are exchanged after the tick only, so the same seed gives the same
    training.
    """

    steps = 0

    def __init__(self, config: TrainingConfig, scenario: Scenario, seed: int, checkpoint: Path | None = None) -> None:
        self.config, self.seed, self._first_seed = config, seed, training_seeds(seed)
        self.tasks = config.tasks(scenario)
        self.episodes = 0
        self.losses: list[float] = []
        self.ended: list[int] = []
        """Lengths in steps of the episodes that ended since the last report."""
        found = None if checkpoint is None else read_checkpoint(checkpoint)
        self.prior = self._fit_prior() if found is None else prior_from(found[0])
        self.flying_rng, self.learning_rng = (
            np.random.default_rng(part) for part in np.random.SeedSequence(seed).spawn(2)
        )
        self.learner = Learner(config.observation, config, seed)
        self.flight = MultiTaskFlight(self.tasks, config.observation, self.prior, config.environments, self._next_seed)
        self._early_steps = self.flight.repeat([config.early_step(task) for task in self.tasks])
        self.replay = Replay(
            self._sdraws(),
            self.flight.columns,
            config.observation,
            prioritised=config.prioritised,
            symmetries=config.symmetries,
        )
        self._pool = ThreadPoolExecutor(1, "flying")
        if found is not None and checkpoint is not None:
            self._restore(*found, checkpoint)

    def _fit_prior(self) -> MapPrior:
        observation = self.config.observation
        if not (observation.tours or "chance" in observation.layers):
            return no_prior()
        first = self._first_seed if self.config.map_count else prior_seeds(self.seed)
        return fit_prior(collect_all(self.tasks, first, self.config.prior_notes, self.config.map_count), self.seed)

    def _sdraws(self) -> int:
        sdraws = self.config.replay_steps // self.flight.columns
        least = 2 * self.config.return_steps + self.config.observation.frames
        if sdraws <= least:
            raise InputError(
                f"expected replay_steps of more than {least} times the {self.flight.columns} "
                f"UAVs in training, got {self.config.replay_steps}; raise replay_steps or lower environments"
            )
        return sdraws

    def _next_seed(self) -> int:
        self.episodes += 1
        return episode_seed(self._first_seed, self.episodes, self.config.map_count)

    @property
    def share(self) -> float:
        """Completed share of the training, from 0 to 1."""
        return min(self.steps / self.config.total_steps, 1.0)

    @property
    def done(self) -> bool:
        """Tell whether the training is complete."""
        return self.steps >= self.config.total_steps

    def update(self) -> None:
        """Move every UAV and learn at the same time; then store the moves and start new episodes."""
        self.learner.refresh()
        flying = self._pool.submit(self._fly)
        if self.steps >= self.config.warmup_steps and self.replay.ready(self.config.return_steps) > 0:
            self.losses += [self._learn() for _ in range(self.config.updates_per_tick)]
        flown = flying.result()
        self.replay.add(flown)
        self.steps += int((~flown.over).sum())
        self.ended += self.flight.renew(flown.over)

    def _fly(self) -> Tick:
        flight = self.flight
        over, age = flight.over, flight.age
        flight.observe()
        action, explored = self._choose()
        reward = flight.step(action) + self._early_steps * (flight.coverage < T90)
        return Tick(flight.scene, flight.moves, action, reward, flight.terminal & ~over, explored, over, age)

    def _choose(self) -> tuple[NDArray[np.int64], Mask]:
        """Choose epsilon-greedily; return the moves (C,) and whether each was drawn at random (C,)."""
        flight, mask = self.flight, self.config.mask
        explored = self.flying_rng.random(flight.columns) < self.config.epsilon(self.share)
        draws = self.flying_rng.random((flight.columns, 4)) - (flight.moves[:, :, BLOCKED_AT] if mask else 0.0)
        best = self.learner.greedy(self.learner.acting, flight.scenes, flight.moves, mask=mask)
        return np.where(explored, draws.argmax(axis=1), best), explored

    def _learn(self) -> float:
        config, share = self.config, self.share
        batch = self.replay.sample(
            config.batch, config.return_steps, config.gamma(share), self.learning_rng, importance=config.beta(share)
        )
        loss, errors = self.learner.update(batch, share)
        self.replay.reprioritise(batch.place, errors)
        return loss

    def evaluate(self) -> dict[str, int | float]:
        """Evaluate the averaged weights on all scenarios; return the mean results."""
        first, episodes = evaluation_seeds(self.seed), self.config.evaluation_episodes
        found = [evaluate(self.learner, task, self.prior, episodes, first, self.steps) for task in self.tasks]
        return mean_evaluation(found)._asdict()

    def rank(self, evaluation: Mapping[str, int | float]) -> tuple[float, ...]:
        """Return the key that evaluations are compared by: the score of the averaged weights."""
        return (evaluation["score"],)

    def keep(self, folder: Path) -> None:
        """Keep the averaged weights as the best; :meth:`save` writes them."""
        self.learner.best.load_state_dict(self.learner.average.state_dict())

    def status(self) -> TrainingStatus:
        """Return the current status for a report, and reset its means."""
        loss, episode_steps = (float(np.mean(past)) if past else float("nan") for past in (self.losses, self.ended))
        self.losses.clear()
        self.ended.clear()
        return TrainingStatus(
            total_steps=self.config.total_steps,
            epsilon=self.config.epsilon(self.share),
            loss=loss,
            episodes=self.episodes,
            episode_steps=episode_steps,
        )

    def results(self) -> dict[str, Any]:
        """Return the number of episodes that have begun."""
        return {"episodes": self.episodes}

    def save(self, folder: Path) -> None:
        """Write the checkpoint and the best weights."""
        state = {
            "steps": self.steps,
            "episodes": self.episodes,
            "flying_rng": self.flying_rng.bit_generator.state,
            "learning_rng": self.learning_rng.bit_generator.state,
        }
        tensors = self.learner.tensors() | self.flight.tensors() | self.replay.tensors() | prior_arrays(self.prior)
        write_checkpoint(folder, tensors, state)
        write_weights(
            folder / WEIGHTS,
            arrays(self.learner.best),
            prior_arrays(self.prior),
            self.config.observation,
            self.config.network,
        )

    def _restore(self, tensors: dict[str, NDArray[Any]], state: dict[str, Any], path: Path) -> None:
        """Restore the state that :meth:`save` wrote."""
        with reporting_damage(path):
            for part in (self.learner, self.flight, self.replay):
                part.restore(tensors)
            self.steps, self.episodes = state["steps"], state["episodes"]
            self.flying_rng.bit_generator.state = state["flying_rng"]
            self.learning_rng.bit_generator.state = state["learning_rng"]


def evaluate(
    learner: Learner, task: Scenario, prior: MapPrior, episodes: int, first_seed: int, steps: int
) -> Evaluation:
    """Fly ``episodes`` episodes of a task and return their mean results.

    Their seeds begin at ``first_seed``; ``steps`` is the number of training moves so far.
    """
    seeds = iter(range(first_seed, first_seed + episodes))
    flight = VectorFlight(task, learner.config.observation, prior, episodes, lambda: next(seeds))

    def act() -> None:
        flying = np.flatnonzero(~flight.over)
        flight.observe(flying)
        action = np.full(flight.columns, int(Action.STAY))
        action[flying] = learner.greedy(learner.average, flight.scenes[flying], flight.moves[flying], mask=True)
        flight.step(action)

    return evaluate_world(flight.world, act, steps)


@contextmanager
def _trainee(config: TrainingConfig, scenario: Scenario, seed: int, session: Session) -> Iterator[Training]:
    with Scalars(session):
        yield Training(config, scenario, seed, session.checkpoint)


train = TrainingMethod(partial(new_record, "dddqn"), _trainee)
