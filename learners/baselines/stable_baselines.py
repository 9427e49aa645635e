"""The policy ``sb3:DIR``: what Stable-Baselines3 or sb3-contrib has trained.

The networks are built anew from ``training.json``, and of the model's zip the weights alone are read, with torch's
loader for weights, which runs nothing that a file brings. The library's own ``load`` unpickles what it finds, and so
does resuming a training: do that with files that you trust.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any
from zipfile import ZipFile

from indoor_explorers.env.errors import InputError
from indoor_explorers.learners.baselines.acting import (
    DAMAGE,
    TrainedModel,
    TrainedPolicy,
    read_training,
)
from indoor_explorers.learners.sessions.record import RECORD

#: The learners whose models this policy flies; each has a module of that name.
LEARNERS = ("sb3-a2c", "sb3-dqn", "sb3-maskable-ppo", "sb3-ppo", "sb3-qrdqn")
#: The member of a model's zip that holds the weights.
WEIGHTS = "policy.pth"


@dataclass(frozen=True, kw_only=True)
class StableBaselines(TrainedPolicy):
    """Fly what ``sb3-ppo`` and its like have trained: ``sb3:DIR``."""

    MODEL = "model.zip"

    @staticmethod
    @lru_cache(maxsize=8)
    def opened(folder: Path, model: Path, changed: tuple[int, ...]) -> TrainedModel:
        """Open a training's model."""
        record, module, config = read_training(folder, LEARNERS)
        policy = module.KIND.untrained(config, record.inputs)
        try:
            policy.load_state_dict(_weights(model))
        except DAMAGE as error:
            raise InputError(
                f"{model}: expected the zip of a model that {record.learner} trained with this {RECORD}, got something "
                f"else ({error!r:.200})"
            ) from error
        policy.set_training_mode(False)
        return TrainedModel(record, config, partial(module.KIND.rate, policy))


def _weights(model: Path) -> dict[str, Any]:
    import torch  # loads when it is used, and not to list the policies

    with ZipFile(model) as archive:
        weights: dict[str, Any] = torch.load(io.BytesIO(archive.read(WEIGHTS)), map_location="cpu", weights_only=True)
    return weights
