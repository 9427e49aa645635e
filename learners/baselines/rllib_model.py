"""RLlib's networks: their configuration and their action scores."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from typing import Any, cast

import numpy as np
import torch
from gymnasium.spaces import Box, Dict, Discrete, Space
from numpy.typing import NDArray
from ray.rllib.algorithms.algorithm_config import AlgorithmConfig
from ray.rllib.core.columns import Columns
from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig
from ray.rllib.core.rl_module.rl_module import RLModule, RLModuleSpec
from ray.rllib.core.rl_module.torch import TorchRLModule

from indoor_explorers.env.observations import Masked, Observation
from indoor_explorers.env.observations.factories import MASK
from indoor_explorers.learners.baselines.config import BaselineConfig
from indoor_explorers.learners.baselines.rllib_masking import UNMASKED


class RllibConfig(BaselineConfig):
    """Hyperparameters that all algorithms of RLlib share."""

    @property
    def masked(self) -> bool:
        """Whether the network gets the action mask and never draws an illegal move."""
        return False

    def algorithm(self) -> AlgorithmConfig:
        """Return RLlib's configuration of the algorithm with these hyperparameters."""
        raise NotImplementedError

    def module(self) -> type[RLModule]:
        """Return the class of the network."""
        raise NotImplementedError

    @property
    def environment_recipe(self) -> Observation:
        """The environment's observation, with the mask if :attr:`masked`."""
        return Masked(self.recipe, UNMASKED) if self.masked else self.recipe

    def spec(self) -> RLModuleSpec:
        """Return RLlib's specification of the network; its spaces are still open."""
        sizes = DefaultModelConfig(
            fcnet_hiddens=list(self.hidden), fcnet_activation="relu", head_fcnet_hiddens=[], vf_share_layers=False
        )
        return RLModuleSpec(module_class=self.module(), model_config=sizes)

    def untrained(self, inputs: int) -> TorchRLModule:
        """Return an untrained network for observations of ``inputs`` numbers."""
        with quietly():
            spec = self.spec()
            space: Space[Any] = Box(0.0, 1.0, (inputs,), np.float32)
            spec.observation_space = Dict({UNMASKED: space, MASK: Box(0, 1, (5,), np.int8)}) if self.masked else space
            spec.action_space = Discrete(5)
            spec.model_config = self.algorithm().model_config | asdict(cast(DefaultModelConfig, spec.model_config))
            spec.inference_only = True
            return cast(TorchRLModule, spec.build())

    def rate(self, module: TorchRLModule, rows: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return a network's action scores (B, 5) for observations (B, D); no action is masked."""
        seen: Any = torch.from_numpy(rows)
        if self.masked:
            seen = {UNMASKED: seen, MASK: torch.ones((len(rows), 5))}
        with torch.no_grad():
            found: NDArray[np.float32] = module.forward_inference({Columns.OBS: seen})[
                Columns.ACTION_DIST_INPUTS
            ].numpy()
        return found


@contextmanager
def quietly() -> Iterator[None]:
    """Silence RLlib's messages about its API stack, deprecations and re-registered environments."""
    loggers = [logging.getLogger(name) for name in ("ray", "ray.rllib")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message=".*Overriding environment .* already in registry")
            yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)
