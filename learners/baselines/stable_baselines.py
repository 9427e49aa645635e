"""The policy ``sb3:DIR``: what Stable-Baselines3 or sb3-contrib has trained.

The networks are built anew from ``training.json``, and of the model's zip the weights alone are read, with torch's
loader for weights, which runs nothing that a file brings. The library's own ``load`` unpickles what it finds, and so
does resuming a training: do that with files that you trust.
"""

from __future__ import annotations

import io
import pickle
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

import torch

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.validation import validated
from indoor_explorers.learners.baselines.acting import Trained, TrainedPolicy, changed, folder_and_model
from indoor_explorers.learners.baselines.record import RECORD, read_record
from indoor_explorers.learners.baselines.sb3_training import MODEL, Kind

#: The learners whose models this policy flies; each has a module of that name.
LEARNERS = ("sb3-a2c", "sb3-dqn", "sb3-maskable-ppo", "sb3-ppo", "sb3-qrdqn")
#: The member of a model's zip that holds the weights.
WEIGHTS = "policy.pth"


@dataclass(frozen=True, kw_only=True)
class StableBaselines(TrainedPolicy):
    """Fly what ``sb3-ppo`` and its like have trained: ``sb3:DIR``."""

    def model_file(self) -> Path:
        """Return the path of the model's zip."""
        return folder_and_model(self.path, MODEL)[1]

    def trained(self) -> Trained:
        """Return what the path holds.

        Raises:
            InputError: it is missing, damaged or another library's.

        """
        folder, model = folder_and_model(self.path, MODEL)
        return _opened(folder, model, changed(folder / RECORD, model))


@lru_cache(maxsize=8)
def _opened(folder: Path, model: Path, changed: tuple[int, ...]) -> Trained:
    record = read_record(folder)
    if record.learner not in LEARNERS:
        raise InputError(f"{folder}: expected a training of {', '.join(LEARNERS)}, got one of {record.learner}")
    module = import_module(f"{__package__}.{record.learner.replace('-', '_')}")
    config = validated(module.TrainingConfig, record.config, str(folder / RECORD))
    kind: Kind = module.KIND
    policy = kind.untrained(config, record.inputs)
    try:
        policy.load_state_dict(_weights(model))
    except (RuntimeError, KeyError, BadZipFile, pickle.UnpicklingError, OSError) as error:
        raise InputError(
            f"{model}: expected the zip of a model that {record.learner} trained with this {RECORD}, got something "
            f"else ({error!r:.200})"
        ) from error
    policy.set_training_mode(False)
    return Trained(record, config, partial(kind.rate, policy))


def _weights(model: Path) -> dict[str, Any]:
    with ZipFile(model) as archive:
        weights: dict[str, Any] = torch.load(io.BytesIO(archive.read(WEIGHTS)), map_location="cpu", weights_only=True)
    return weights
