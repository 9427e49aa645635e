"""Train with Stable-Baselines3 or sb3-contrib: one UAV, many episodes in one batched world.

A folder holds ``model.zip``, the model that did best in evaluation, ``checkpoint.zip``, the latest model with its
optimiser, ``replay.pkl``, the replay buffer of off-policy algorithms, and ``training.json``. The first three are the
library's own files. Resuming unpickles them, as SB3 does, and unpickling can run code: resume only trainings that you
trust. Policies read the weights only.
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
from stable_baselines3.common.logger import Logger
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
from indoor_explorers.learners.sessions.train import TrainingMethod

CHECKPOINT, REPLAY = "checkpoint.zip", "replay.pkl"
PACKAGES = ("stable-baselines3", "sb3-contrib")
#: Errors that the library's loaders raise on damaged files.
DAMAGE = (BadZipFile, pickle.UnpicklingError, ValueError, KeyError, AttributeError, RuntimeError, EOFError, OSError)


class StableBaselinesConfig(BaselineConfig):
    """Hyperparameters that all algorithms of Stable-Baselines3 share."""

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of the algorithm's constructor."""
        return {"learning_rate": self.learning_rate, "gamma": self.gamma, "policy_kwargs": self.network()}

    def network(self) -> dict[str, Any]:
        """Return the arguments of the network's constructor."""
        return {"net_arch": list(self.hidden)}


class Sb3Algorithm(NamedTuple):
    """One algorithm of the library."""

    learner: str
    """Name of the learner."""
    model_class: type[BaseAlgorithm]
    """Class of the algorithm."""
    policy_class: type[BasePolicy]
    """Class of its networks."""
    scores: Callable[[Any, torch.Tensor], torch.Tensor]
    """Computes the action scores (B, 5) of a policy for observations (B, D)."""

    def rate(self, policy: BasePolicy, rows: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return a policy's action scores (B, 5) for observations (B, D)."""
        with torch.no_grad():
            found: NDArray[np.float32] = self.scores(policy, torch.from_numpy(rows)).numpy()
        return found

    def untrained(self, config: StableBaselinesConfig, inputs: int) -> BasePolicy:
        """Return untrained networks for observations of ``inputs`` numbers."""
        return self.policy_class(Box(0.0, 1.0, (inputs,)), Discrete(5), lambda _: 0.0, **config.network())


def logits(policy: Any, rows: torch.Tensor) -> torch.Tensor:
    """Return the log-probabilities (B, 5) of an actor-critic's actions for observations (B, D)."""
    found: torch.Tensor = policy.get_distribution(rows).distribution.logits
    return found


def trainer(algorithm: Sb3Algorithm) -> TrainingMethod:
    """Return the ``train`` function of an algorithm.

    The same seed gives the same model. A resumed training starts new episodes and new random numbers, so its result
    differs from that of an uninterrupted one.
    """
    record = partial(baseline_record, algorithm.learner, PACKAGES, new_lone_world)
    return TrainingMethod(record, partial(_trainee, algorithm), CHECKPOINT, StableBaselines.MODEL)


def _trainee(
    algorithm: Sb3Algorithm, config: StableBaselinesConfig, scenario: Scenario, seed: int, session: Session
) -> AbstractContextManager[StableBaselinesTrainee]:
    task, first = config.task(scenario), training_seeds(seed)
    envs = StableBaselinesVecEnv(config.environments, scenario=task, observation=config.recipe, first_seed=first)
    trainee = StableBaselinesTrainee(algorithm, _model(algorithm, config, envs, session, seed), config, scenario, seed)
    envs.seed(trainee.steps)
    return nullcontext(trainee)


def _model(
    algorithm: Sb3Algorithm, config: StableBaselinesConfig, envs: StableBaselinesVecEnv, session: Session, seed: int
) -> BaseAlgorithm:
    if session.checkpoint is None:
        return algorithm.model_class("MlpPolicy", envs, seed=seed, device="cpu", **config.arguments())
    try:
        model = algorithm.model_class.load(session.checkpoint, env=envs, device="cpu")
        if isinstance(model, OffPolicyAlgorithm):
            model.load_replay_buffer(session.out / REPLAY)
    except DAMAGE as error:
        raise InputError(
            f"{session.out}: expected a checkpoint of {algorithm.learner}, got a damaged one ({error!r})"
        ) from error
    return model


class StableBaselinesTrainee(BaselineTrainee):
    """A model of Stable-Baselines3, trained by the library's own loop."""

    def __init__(
        self,
        algorithm: Sb3Algorithm,
        model: BaseAlgorithm,
        config: StableBaselinesConfig,
        scenario: Scenario,
        seed: int,
    ) -> None:
        super().__init__(config, scenario, seed)
        self.model, self._algorithm = model, algorithm
        model.set_logger(Logger(folder=None, output_formats=[]))  # the library's own makes a folder in /tmp

    @property
    def steps(self) -> int:
        """Moves made, all environments together."""
        return self.model.num_timesteps

    def train(self, session: Session) -> None:
        """Train by the library's own loop."""
        remaining = self.config.total_steps - self.steps
        if remaining > 0:
            self.model.learn(remaining, _Callback(session, self), log_interval=None, reset_num_timesteps=False)  # type: ignore[arg-type]  # None is meant: never

    @property
    def loss(self) -> float:
        """The latest loss; NaN before the first one."""
        logged = self.model.logger.name_to_value
        return float(logged.get("train/loss", logged.get("train/policy_loss", math.nan)))

    @property
    def epsilon(self) -> float | None:
        """Current probability of a random move; None for a stochastic policy."""
        return getattr(self.model, "exploration_rate", None)

    def scores(self, rows: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return action scores (B, 5), higher is better, for observations (B, D)."""
        self.model.policy.set_training_mode(False)
        return self._algorithm.rate(self.model.policy, rows)

    def keep(self, folder: Path) -> None:
        """Write the current model as the best one."""
        self._save(folder / StableBaselines.MODEL)

    def save(self, folder: Path) -> None:
        """Write the checkpoint, and the replay buffer of an off-policy algorithm."""
        self._save(folder / CHECKPOINT)
        if isinstance(self.model, OffPolicyAlgorithm):
            with written_whole(folder / REPLAY) as unfinished:
                self.model.save_replay_buffer(unfinished)

    def _save(self, path: Path) -> None:
        with written_whole(path) as unfinished:
            self.model.save(unfinished)


class _Callback(BaseCallback):
    """Evaluate and write checkpoints between rollouts, report progress, and stop after a Ctrl-C."""

    def __init__(self, session: Session, trainee: StableBaselinesTrainee) -> None:
        super().__init__()
        self._session, self._trainee = session, trainee

    def _on_rollout_start(self) -> None:
        self._session.after_update(self._trainee)

    def _on_step(self) -> bool:
        self._session.report(self._trainee)
        return not self._session.interrupted
