"""RLlib's PPO network with an action mask: illegal actions are never drawn (Huang and Ontanon 2022, arXiv:2006.14171).

RLlib's own example of such a network uses a module that RLlib has deprecated.
"""

from __future__ import annotations

from typing import Any

import torch
from gymnasium.spaces import Dict
from ray.rllib.algorithms.ppo.torch.default_ppo_torch_rl_module import DefaultPPOTorchRLModule
from ray.rllib.core.columns import Columns

from indoor_explorers.env.observations.factories import MASK

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
