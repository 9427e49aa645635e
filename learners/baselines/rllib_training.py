"""Train with RLlib: a team whose UAVs share one network, or one UAV.

A folder holds ``weights.safetensors``, the network that did best in evaluation, ``checkpoint/``, the library's own
files of the whole algorithm, and ``training.json``. To resume unpickles the checkpoint, as RLlib does: only go on
with folders that you trust. To fly reads ``weights.safetensors`` alone, which holds numbers and nothing that could
run. Everything happens in this process, on RLlib's new API stack, beside a local Ray without a dashboard.
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
from indoor_explorers.learners.sessions.train import TrainingMethod, train

CHECKPOINT = "checkpoint"
PACKAGES = ("ray", "pettingzoo")
#: The environment's and the network's names in RLlib, and the file of a checkpoint that says how old it is.
TEAM, SHARED, STEPS = "indoor-explorers-team", "shared", "moves.txt"
#: What the library's loaders raise on damaged files.
DAMAGE = (pickle.UnpicklingError, ValueError, KeyError, AttributeError, RuntimeError, EOFError, OSError, TypeError)
#: Bytes of the object store, which a training in one process hardly uses.
STORE = 100 * 2**20


class TrainingTeam(TeamEnv):
    """A team, or one UAV, whose episodes have the seeds of the training, whatever seeds RLlib resets with."""

    def __init__(self, scenario: Scenario, observation: Observation, seeds: Iterator[int]) -> None:
        super().__init__(scenario, observation, None, None, 0)
        self._seeds = seeds

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Arrays], dict[str, dict[str, Any]]]:
        """Start the next episode of the training."""
        return super().reset(next(self._seeds), options)


def trainer(learner: str) -> partial[Path]:
    """Return the ``train`` function of an algorithm.

    A resumed training begins new episodes, so that it differs from one that was not stopped.
    """
    record = partial(baseline_record, learner, PACKAGES, new_world)
    return partial(train, TrainingMethod(record, _trainee, CHECKPOINT, Rllib.MODEL))


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
    """An algorithm of RLlib."""

    config: RllibConfig
    steps = 0
    loss = math.nan

    def __init__(self, config: RllibConfig, algorithm: Algorithm, scenario: Scenario, seed: int) -> None:
        super().__init__(config, scenario, seed)
        self._algorithm = algorithm

    def update(self) -> None:
        """Fly and learn for one round."""
        result = self._algorithm.train()
        self.steps += int(result["env_runners"].get("num_module_steps_sampled", {}).get(SHARED, 0))
        learned = result.get("learners", {}).get(SHARED, {})
        self.loss = float(learned.get("total_loss", math.nan))

    def scores(self, rows: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return (B, 5) numbers, the higher the better, for observations (B, D)."""
        return self.config.rate(self._module(), rows)

    def keep(self, folder: Path) -> None:
        """Write the network as the one to fly."""
        state = self._module().state_dict()
        with written_whole(folder / Rllib.MODEL) as unfinished:
            save_file({name: tensor.contiguous() for name, tensor in state.items()}, unfinished)

    def _module(self) -> TorchRLModule:
        return cast(TorchRLModule, self._algorithm.get_module(SHARED))

    def save(self, folder: Path) -> None:
        """Write the checkpoint beside the last one, and then in its place."""
        partial, last = folder / f".{CHECKPOINT}.partial", folder / CHECKPOINT
        shutil.rmtree(partial, ignore_errors=True)
        self._algorithm.save_to_path(str(partial.resolve()))
        (partial / STEPS).write_text(str(self.steps), encoding="utf-8")
        shutil.rmtree(last, ignore_errors=True)
        partial.rename(last)

    def restore(self, checkpoint: Path) -> None:
        """Go on from a checkpoint."""
        try:
            self.steps = int((checkpoint / STEPS).read_text(encoding="utf-8"))
            self._algorithm.restore_from_path(str(checkpoint.resolve()))
        except DAMAGE as error:
            raise InputError(
                f"{checkpoint}: expected a checkpoint of RLlib, got a damaged one ({error!r:.200})"
            ) from error

    def stop(self) -> None:
        """Free everything, and delete the folder for logs that RLlib makes in the user's home."""
        logs = self._algorithm.logdir
        self._algorithm.stop()
        shutil.rmtree(logs, ignore_errors=True)


@contextmanager
def _local_ray() -> Iterator[None]:
    """Run a Ray of our own, unless there is one already.

    Raises:
        RunError: it does not start.

    """
    if ray.is_initialized():
        yield
        return
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    quiet: dict[str, Any] = {"log_to_driver": False, "logging_level": logging.ERROR}
    try:
        ray.init("local", include_dashboard=False, object_store_memory=STORE, **quiet)
    except Exception as error:  # Ray raises nothing narrower
        raise RunError(f"Ray could not be started here: {error}; try again when the machine is less busy") from error
    try:
        yield
    finally:
        ray.shutdown()
