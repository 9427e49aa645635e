"""The policy ``sb3:DIR``: a network that Stable-Baselines3 or sb3-contrib has trained.

The network is built from ``training.json``. Of the model's zip only the weights are read, with torch's
``weights_only`` loader, which runs no code from the file. The library's own ``load`` unpickles the file, and so does
resuming a training: do either only with files that you trust.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from zipfile import ZipFile

from indoor_explorers.learners.baselines.acting import TrainedPolicy
from indoor_explorers.learners.baselines.trainee import Scores

#: Name of the weights in a model's zip.
WEIGHTS = "policy.pth"


@dataclass(frozen=True, kw_only=True)
class StableBaselines(TrainedPolicy):
    """Fly a network trained by one of the ``sb3-*`` learners: ``sb3:DIR``."""

    MODEL = "model.zip"
    LEARNERS = ("sb3-a2c", "sb3-dqn", "sb3-maskable-ppo", "sb3-ppo", "sb3-qrdqn")

    @staticmethod
    def scores(module: Any, config: Any, inputs: int, model: Path) -> Scores:
        """Return the network with the weights of a file."""
        import torch  # imported late: listing the policies needs no torch

        network = module.ALGORITHM.untrained(config, inputs)
        with ZipFile(model) as archive:
            weights = io.BytesIO(archive.read(WEIGHTS))
        network.load_state_dict(torch.load(weights, map_location="cpu", weights_only=True))
        network.set_training_mode(False)
        return partial(module.ALGORITHM.rate, network)
