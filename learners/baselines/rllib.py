"""The policy ``rllib:DIR``: what RLlib has trained, on a team or on one UAV.

The network is built anew by RLlib from ``training.json``, and its weights are read from a safetensors file, which
holds numbers and nothing that could run. The checkpoint beside it is pickled: resume, and open it with RLlib, only
where you trust it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path

from safetensors import SafetensorError

from indoor_explorers.env.errors import InputError
from indoor_explorers.learners.baselines.acting import (
    DAMAGE,
    TrainedModel,
    TrainedPolicy,
    read_training,
)
from indoor_explorers.learners.sessions.record import RECORD

#: The learners whose networks this policy flies; each has a module of that name.
LEARNERS = ("rllib-ppo", "rllib-sac")


@dataclass(frozen=True, kw_only=True)
class Rllib(TrainedPolicy):
    """Fly what ``rllib-ppo`` and its like have trained: ``rllib:DIR``."""

    MODEL = "weights.safetensors"

    @staticmethod
    @lru_cache(maxsize=8)
    def opened(folder: Path, model: Path, changed: tuple[int, ...]) -> TrainedModel:
        """Open a training's model."""
        from safetensors.torch import load_file  # torch loads when it is used, and not to list the policies

        record, _, config = read_training(folder, LEARNERS)
        module = config.untrained(record.inputs)
        try:
            weights = load_file(model)  # the critic's among them, which flying does without
            module.load_state_dict({name: weights[name] for name in module.state_dict()})
        except (SafetensorError, *DAMAGE) as error:
            raise InputError(
                f"{model}: expected the weights that {record.learner} trained with this {RECORD}, got something else "
                f"({error!r:.200})"
            ) from error
        return TrainedModel(record, config, partial(config.rate, module))
