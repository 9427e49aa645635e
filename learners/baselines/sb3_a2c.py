"""A2C of Stable-Baselines3, the synchronous form of A3C (Mnih et al. 2016, arXiv:1602.01783)."""

from __future__ import annotations

from typing import Any

from pydantic import Field
from stable_baselines3 import A2C
from stable_baselines3.common.policies import ActorCriticPolicy

from indoor_explorers.learners.baselines.config import ActorCriticSettings
from indoor_explorers.learners.baselines.sb3_training import Sb3Algorithm, StableBaselinesConfig, logits, trainer

ALGORITHM = Sb3Algorithm("sb3-a2c", A2C, ActorCriticPolicy, logits)


class TrainingConfig(StableBaselinesConfig, ActorCriticSettings):
    """The hyperparameters of A2C; all others have the library's defaults."""

    learning_rate: float = Field(7e-4, gt=0.0)
    """RMSprop's step size."""
    rollout: int = Field(8, ge=1)
    """Steps of each environment between two updates."""

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of the algorithm's constructor."""
        return super().arguments() | {
            "n_steps": self.rollout,
            "gae_lambda": self.gae_lambda,
            "ent_coef": self.entropy,
            "vf_coef": self.value_weight,
            "max_grad_norm": self.gradient_clip,
        }


train = trainer(ALGORITHM)
