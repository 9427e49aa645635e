"""The policy ``rllib:DIR``: what RLlib has trained, on a team or on one UAV.

The network is built anew by RLlib from ``training.json``, and its weights are read from a safetensors file, which
holds numbers and nothing that could run. The checkpoint beside it is pickled: resume, and open it with RLlib, only
where you trust it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from indoor_explorers.learners.baselines.acting import TrainedPolicy
from indoor_explorers.learners.baselines.evaluation import Scores


@dataclass(frozen=True, kw_only=True)
class Rllib(TrainedPolicy):
    """Fly what ``rllib-ppo`` and its like have trained: ``rllib:DIR``."""

    MODEL = "weights.safetensors"
    LEARNERS = ("rllib-ppo", "rllib-sac")

    @staticmethod
    def scores(module: Any, config: Any, inputs: int, model: Path) -> Scores:
        """Return the network in a file."""
        from safetensors.torch import load_file  # torch loads when it is used, and not to list the policies

        network, weights = config.untrained(inputs), load_file(model)
        network.load_state_dict({name: weights[name] for name in network.state_dict()})  # without the critic's
        return partial(config.rate, network)
