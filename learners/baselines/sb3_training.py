"""Train with Stable-Baselines3 or sb3-contrib: one UAV, many episodes in one batched world.

A folder holds ``model.zip``, the model that did best in evaluation, ``checkpoint.zip``, the latest one with its
optimiser, ``replay.pkl``, the replay of those that have one, and ``training.json``. These are the library's own
files. To resume unpickles them, as SB3 does: only go on with folders that you trust. To fly reads weights alone.
"""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import BadZipFile

import numpy as np
import torch
from gymnasium.spaces import Box, Discrete
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.policies import BasePolicy

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import written_whole
from indoor_explorers.env.interfaces.common import new_lone_world
from indoor_explorers.env.interfaces.stable_baselines import StableBaselinesVecEnv
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.baselines.config import BaselineConfig
from indoor_explorers.learners.baselines.stable_baselines import StableBaselines
from indoor_explorers.learners.baselines.trainee import BaselineTrainee, baseline_record
from indoor_explorers.learners.sessions.seeds import training_seeds
from indoor_explorers.learners.sessions.session import Session
from indoor_explorers.learners.sessions.train import TrainingMethod, train

CHECKPOINT, REPLAY = "checkpoint.zip", "replay.pkl"
PACKAGES = ("stable-baselines3", "sb3-contrib")
#: What the library's loaders raise on damaged files.
DAMAGE = (BadZipFile, pickle.UnpicklingError, ValueError, KeyError, AttributeError, RuntimeError, EOFError, OSError)


class StableBaselinesConfig(BaselineConfig):
    """What all algorithms of Stable-Baselines3 are told."""

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of the algorithm's constructor."""
        return {"learning_rate": self.learning_rate, "gamma": self.gamma, "policy_kwargs": self.network()}

    def network(self) -> dict[str, Any]:
        """Return the arguments of the network's constructor."""
        return {"net_arch": list(self.hidden)}


class Kind(NamedTuple):
    """One algorithm of the library."""

    learner: str
    """Name of the learner."""
    algorithm: type[BaseAlgorithm]
    """Its class."""
    policy: type[BasePolicy]
    """The class of its networks."""
    scores: Callable[[Any, torch.Tensor], torch.Tensor]
    """Gives what ``policy`` thinks of the five actions, (B, 5), for observations (B, D)."""

    def rate(self, policy: BasePolicy, rows: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return what a policy thinks of the actions (B, 5) for observations (B, D)."""
        with torch.no_grad():
            found: NDArray[np.float32] = self.scores(policy, torch.from_numpy(rows)).numpy()
        return found

    def untrained(self, config: StableBaselinesConfig, inputs: int) -> BasePolicy:
        """Return the networks of a training before it begins, for observations of ``inputs`` numbers."""
        return self.policy(Box(0.0, 1.0, (inputs,)), Discrete(5), lambda _: 0.0, **config.network())


def logits(policy: Any, rows: torch.Tensor) -> torch.Tensor:
    """Return the log-probabilities of an actor-critic's actions."""
    found: torch.Tensor = policy.get_distribution(rows).distribution.logits
    return found


def trainer(kind: Kind) -> partial[Path]:
    """Return the ``train`` function of an algorithm.

    The same seed gives the same model; a resumed training begins new episodes and draws anew, so that it differs from
    one that was not stopped.
    """
    record = partial(baseline_record, kind.learner, PACKAGES, new_lone_world)
    return partial(train, TrainingMethod(record, partial(_trainee, kind), CHECKPOINT, StableBaselines.MODEL))


def _trainee(
    kind: Kind, config: StableBaselinesConfig, scenario: Scenario, seed: int, session: Session
) -> AbstractContextManager[StableBaselinesTrainee]:
    task, first = config.task(scenario), training_seeds(seed)
    envs = StableBaselinesVecEnv(config.environments, scenario=task, observation=config.recipe, first_seed=first)
    trainee = StableBaselinesTrainee(kind, _model(kind, config, envs, session, seed), config, scenario, seed)
    envs.seed(first + trainee.steps)
    return nullcontext(trainee)


def _model(
    kind: Kind, config: StableBaselinesConfig, envs: StableBaselinesVecEnv, session: Session, seed: int
) -> BaseAlgorithm:
    if session.checkpoint is None:
        return kind.algorithm("MlpPolicy", envs, seed=seed, device="cpu", **config.arguments())
    try:
        model = kind.algorithm.load(session.checkpoint, env=envs, device="cpu")
        if isinstance(model, OffPolicyAlgorithm):
            model.load_replay_buffer(session.out / REPLAY)
    except DAMAGE as error:
        raise InputError(
            f"{session.out}: expected a checkpoint of {kind.learner}, got a damaged one ({error!r})"
        ) from error
    return model


class StableBaselinesTrainee(BaselineTrainee):
    """A model of Stable-Baselines3, which has a loop of its own."""

    def __init__(
        self, kind: Kind, model: BaseAlgorithm, config: StableBaselinesConfig, scenario: Scenario, seed: int
    ) -> None:
        super().__init__(config, scenario, seed)
        self.model, self._kind = model, kind

    @property
    def steps(self) -> int:
        """Moves made."""
        return self.model.num_timesteps

    def train(self, session: Session) -> None:
        """Train by the library's own loop."""
        remaining = self.config.total_steps - self.steps
        if remaining > 0:
            self.model.learn(remaining, _Callback(session, self), log_interval=None, reset_num_timesteps=False)  # type: ignore[arg-type]  # None is meant: never

    @property
    def loss(self) -> float:
        """The latest loss; not a number before the first one."""
        told = self.model.logger.name_to_value if hasattr(self.model, "_logger") else {}
        return float(told.get("train/loss", told.get("train/policy_loss", math.nan)))

    @property
    def epsilon(self) -> float | None:
        """Probability of a random move, where the learner has one."""
        return getattr(self.model, "exploration_rate", None)

    def scores(self, rows: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return (B, 5) numbers, the higher the better, for observations (B, D)."""
        self.model.policy.set_training_mode(False)
        return self._kind.rate(self.model.policy, rows)

    def keep(self, folder: Path) -> None:
        """Write the model as the one to fly."""
        self._save(folder / StableBaselines.MODEL)

    def save(self, folder: Path) -> None:
        """Write the checkpoint."""
        self._save(folder / CHECKPOINT)
        if isinstance(self.model, OffPolicyAlgorithm):
            with written_whole(folder / REPLAY) as unfinished:
                self.model.save_replay_buffer(unfinished)

    def _save(self, path: Path) -> None:
        with written_whole(path) as unfinished:
            self.model.save(unfinished)


class _Callback(BaseCallback):
    """Evaluate and write between updates, report, and stop after a Ctrl-C."""

    def __init__(self, session: Session, trainee: StableBaselinesTrainee) -> None:
        super().__init__()
        self._session, self._trainee = session, trainee

    def _on_rollout_start(self) -> None:
        self._session.after_update(self._trainee)

    def _on_step(self) -> bool:
        self._session.report(self._trainee)
        return not self._session.interrupted
