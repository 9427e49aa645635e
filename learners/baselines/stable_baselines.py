"""The policy ``sb3:DIR``: what Stable-Baselines3 or sb3-contrib has trained.

The networks are built anew from ``training.json``, and of the model's zip the weights alone are read, with torch's
loader for weights, which runs nothing that a file brings. The library's own ``load`` unpickles what it finds, and so
does resuming a training: do that with files that you trust.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from zipfile import ZipFile

from indoor_explorers.learners.baselines.acting import TrainedPolicy
from indoor_explorers.learners.baselines.evaluation import Scores

#: The member of a model's zip that holds the weights.
WEIGHTS = "policy.pth"


@dataclass(frozen=True, kw_only=True)
class StableBaselines(TrainedPolicy):
    """Fly what ``sb3-ppo`` and its like have trained: ``sb3:DIR``."""

    MODEL = "model.zip"
    LEARNERS = ("sb3-a2c", "sb3-dqn", "sb3-maskable-ppo", "sb3-ppo", "sb3-qrdqn")

    @staticmethod
    def scores(module: Any, config: Any, inputs: int, model: Path) -> Scores:
        """Return the network in a file."""
        import torch  # loads when it is used, and not to list the policies

        network = module.KIND.untrained(config, inputs)
        with ZipFile(model) as archive:
            weights = io.BytesIO(archive.read(WEIGHTS))
        network.load_state_dict(torch.load(weights, map_location="cpu", weights_only=True))
        network.set_training_mode(False)
        return partial(module.KIND.rate, network)
