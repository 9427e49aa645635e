"""Train with RLlib: one UAV, or a team whose UAVs share one network.

A folder holds ``weights.safetensors``, the network that did best in evaluation, ``checkpoint/``, RLlib's own files of
the whole algorithm, and ``training.json``. Resuming unpickles the checkpoint, as RLlib does, and unpickling can run
code: resume only trainings that you trust. Policies read ``weights.safetensors`` only, which holds no executable code.
Training runs in this process, on RLlib's new API stack, with a local Ray without a dashboard.
"""

from __future__ import annotations

import logging
import math
import os
import pickle
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any, cast

import numpy as np
import ray
from numpy.typing import NDArray
from ray.rllib.algorithms.algorithm import Algorithm
from ray.rllib.core.rl_module.multi_rl_module import MultiRLModuleSpec
from ray.rllib.core.rl_module.torch import TorchRLModule
from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv
from ray.tune.registry import register_env
from safetensors.torch import save_file

from indoor_explorers.env.errors import InputError, RunError
from indoor_explorers.env.files import written_whole
from indoor_explorers.env.interfaces.common import new_world
from indoor_explorers.env.interfaces.pettingzoo_env import TeamEnv
from indoor_explorers.env.observations import Observation
from indoor_explorers.env.observations.base import Arrays
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.baselines.rllib import Rllib
from indoor_explorers.learners.baselines.rllib_model import RllibConfig, quietly
from indoor_explorers.learners.baselines.trainee import BaselineTrainee, baseline_record
from indoor_explorers.learners.sessions.seeds import training_seeds
from indoor_explorers.learners.sessions.session import Session
from indoor_explorers.learners.sessions.train import TrainingMethod

CHECKPOINT = "checkpoint"
PACKAGES = ("ray", "pettingzoo")
#: Names of the environment and of the network in RLlib, and the file in a checkpoint with the moves made so far.
TEAM, SHARED, STEPS = "indoor-explorers-team", "shared", "moves.txt"
#: Errors that RLlib's loaders raise on damaged files.
DAMAGE = (pickle.UnpicklingError, ValueError, KeyError, AttributeError, RuntimeError, EOFError, OSError, TypeError)
#: Bytes of Ray's object store, which a training in one process hardly uses.
STORE = 100 * 2**20


class TrainingTeam(TeamEnv):
    """A team, or one UAV, that takes its episode seeds from the training and ignores those of RLlib."""

    def __init__(self, scenario: Scenario, observation: Observation, seeds: Iterator[int]) -> None:
        super().__init__(scenario, observation, None, None, 0)
        self._seeds = seeds

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Arrays], dict[str, dict[str, Any]]]:
        """Start the next episode of the training."""
        return super().reset(next(self._seeds), options)


def trainer(learner: str) -> TrainingMethod:
    """Return the ``train`` function of an algorithm.

    A resumed training starts new episodes, so its result differs from that of an uninterrupted one.
    """
    record = partial(baseline_record, learner, PACKAGES, new_world)
    return TrainingMethod(record, _trainee, CHECKPOINT, Rllib.MODEL)


@contextmanager
def _trainee(config: RllibConfig, scenario: Scenario, seed: int, session: Session) -> Iterator[RllibTrainee]:
    seeds = count(training_seeds(seed) + session.record.steps)
    task, observation = config.task(scenario), config.environment_recipe
    register_env(TEAM, lambda _: ParallelPettingZooEnv(TrainingTeam(task, observation, seeds)))
    with _local_ray(), quietly():
        trainee = RllibTrainee(config, _algorithm(config, seed), scenario, seed)
        try:
            if session.checkpoint is not None:
                trainee.restore(session.checkpoint)
            yield trainee
        finally:
            trainee.stop()


def _algorithm(config: RllibConfig, seed: int) -> Algorithm:
    description = (
        config.algorithm()
        .environment(TEAM, disable_env_checking=True)
        .env_runners(num_env_runners=0, num_envs_per_env_runner=config.environments)
        .learners(num_learners=0)
        .multi_agent(policies={SHARED}, policy_mapping_fn=_shared)
        .rl_module(rl_module_spec=MultiRLModuleSpec(rl_module_specs={SHARED: config.spec()}))
        .debugging(seed=seed, log_level="ERROR")
    )
    built: Algorithm = description.build_algo()
    return built


def _shared(agent: Any, episode: Any, **_: Any) -> str:
    return SHARED


class RllibTrainee(BaselineTrainee):
    """One of RLlib's algorithms in training."""

    config: RllibConfig
    steps = 0
    loss = math.nan

    def __init__(self, config: RllibConfig, algorithm: Algorithm, scenario: Scenario, seed: int) -> None:
        super().__init__(config, scenario, seed)
        self._algorithm = algorithm

    def update(self) -> None:
        """Run one training iteration of RLlib."""
        result = self._algorithm.train()
        self.steps += int(result["env_runners"].get("num_module_steps_sampled", {}).get(SHARED, 0))
        learned = result.get("learners", {}).get(SHARED, {})
        self.loss = float(learned.get("total_loss", math.nan))

    def scores(self, rows: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return action scores (B, 5), higher is better, for observations (B, D)."""
        return self.config.rate(self._module(), rows)

    def keep(self, folder: Path) -> None:
        """Write the current network as the best one."""
        state = self._module().state_dict()
        with written_whole(folder / Rllib.MODEL) as unfinished:
            save_file({name: tensor.contiguous() for name, tensor in state.items()}, unfinished)

    def _module(self) -> TorchRLModule:
        return cast(TorchRLModule, self._algorithm.get_module(SHARED))

    def save(self, folder: Path) -> None:
        """Write the checkpoint to a temporary folder, then replace the last one."""
        partial, last = folder / f".{CHECKPOINT}.partial", folder / CHECKPOINT
        shutil.rmtree(partial, ignore_errors=True)
        self._algorithm.save_to_path(str(partial.resolve()))
        (partial / STEPS).write_text(str(self.steps), encoding="utf-8")
        shutil.rmtree(last, ignore_errors=True)
        partial.rename(last)

    def restore(self, checkpoint: Path) -> None:
        """Restore the algorithm from a checkpoint.

        Raises :class:`InputError` if the checkpoint is damaged.
        """
        try:
            self.steps = int((checkpoint / STEPS).read_text(encoding="utf-8"))
            self._algorithm.restore_from_path(str(checkpoint.resolve()))
        except DAMAGE as error:
            raise InputError(
                f"{checkpoint}: expected a checkpoint of RLlib, got a damaged one ({error!r:.200})"
            ) from error

    def stop(self) -> None:
        """Release all resources, and delete the log folder that RLlib creates in the user's home."""
        logs = self._algorithm.logdir
        self._algorithm.stop()
        shutil.rmtree(logs, ignore_errors=True)


@contextmanager
def _local_ray() -> Iterator[None]:
    """Run a local Ray, unless this process is connected to one already.

    Raises :class:`RunError` if Ray does not start.
    """
    if ray.is_initialized():
        yield
        return
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    logging_settings: dict[str, Any] = {"log_to_driver": False, "logging_level": logging.ERROR}
    try:
        ray.init("local", include_dashboard=False, object_store_memory=STORE, **logging_settings)
    except Exception as error:  # Ray raises nothing narrower
        raise RunError(f"Ray could not be started here: {error}; try again when the machine is less busy") from error
    try:
        yield
    finally:
        ray.shutdown()
