"""RLlib's networks: their configuration, their action scores and PPO's action mask.

With the mask, illegal actions are never drawn (Huang and Ontanon 2022, arXiv:2006.14171). RLlib's own example of such a
network uses a module that RLlib has deprecated.
"""

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
from ray.rllib.algorithms.ppo.torch.default_ppo_torch_rl_module import DefaultPPOTorchRLModule
from ray.rllib.core.columns import Columns
from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig
from ray.rllib.core.rl_module.rl_module import RLModule, RLModuleSpec
from ray.rllib.core.rl_module.torch import TorchRLModule

from indoor_explorers.env.observations import Masked, Observation
from indoor_explorers.env.observations.factories import MASK
from indoor_explorers.learners.baselines.config import BaselineConfig

#: Key of the observation in a dict that also holds its mask.
UNMASKED = "observations"


class MaskedPPOModule(DefaultPPOTorchRLModule):
    """Take a dict of an observation and its mask, and set the logits of illegal actions to the dtype's minimum."""

    def __init__(self, *, observation_space: Dict, **settings: Any) -> None:
        super().__init__(observation_space=observation_space[UNMASKED], **settings)  # type: ignore[no-untyped-call]  # RLlib leaves it untyped

    def _forward(self, batch: dict[str, Any], **settings: Any) -> dict[str, Any]:
        return _masked(super()._forward(_bare(batch), **settings), batch)

    def _forward_train(self, batch: dict[str, Any], **settings: Any) -> dict[str, Any]:
        return _masked(super()._forward_train(_bare(batch), **settings), batch)

    def compute_values(self, batch: dict[str, Any], embeddings: Any = None) -> Any:
        """Return the values of states; the mask does not affect them."""
        return super().compute_values(_bare(batch), embeddings)


def _bare(batch: dict[str, Any]) -> dict[str, Any]:
    """Return the batch without its masks."""
    return {**batch, Columns.OBS: batch[Columns.OBS][UNMASKED]}


def _masked(output: dict[str, Any], batch: dict[str, Any]) -> dict[str, Any]:
    logits = output[Columns.ACTION_DIST_INPUTS]
    legal = batch[Columns.OBS][MASK] > 0
    return {**output, Columns.ACTION_DIST_INPUTS: logits.masked_fill(~legal, torch.finfo(logits.dtype).min)}


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
