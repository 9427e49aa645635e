"""The policy ``rllib:DIR``: a network that RLlib has trained, for a team or one UAV.

RLlib builds the network from ``training.json``; its weights are read from a safetensors file, which holds no
executable code. The checkpoint beside it is pickled, and unpickling can run code: resume only trainings that you
trust.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from indoor_explorers.learners.baselines.acting import TrainedPolicy
from indoor_explorers.learners.baselines.trainee import Scores


@dataclass(frozen=True, kw_only=True)
class Rllib(TrainedPolicy):
    """Fly a network trained by one of the ``rllib-*`` learners: ``rllib:DIR``."""

    MODEL = "weights.safetensors"
    LEARNERS = ("rllib-ppo", "rllib-sac")

    @staticmethod
    def scores(module: Any, config: Any, inputs: int, model: Path) -> Scores:
        """Return the network with the weights of a file."""
        from safetensors.torch import load_file  # imported late: listing the policies needs no torch

        network, weights = config.untrained(inputs), load_file(model)
        network.load_state_dict({name: weights[name] for name in network.state_dict()})  # all but the critic's
        return partial(config.rate, network)
