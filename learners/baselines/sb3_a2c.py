"""A2C of Stable-Baselines3, the synchronous form of A3C: Mnih et al. 2016, arXiv:1602.01783."""

from __future__ import annotations

from typing import Any

from pydantic import Field
from stable_baselines3 import A2C
from stable_baselines3.common.policies import ActorCriticPolicy

from indoor_explorers.learners.baselines.sb3_training import (
    Kind,
    StableBaselinesConfig,
    logits,
    trainer,
)

KIND = Kind("sb3-a2c", A2C, ActorCriticPolicy, logits)


class TrainingConfig(StableBaselinesConfig):
    """Every hyperparameter of an A2C; those not named here are the library's own."""

    learning_rate: float = Field(7e-4, gt=0.0)
    """RMSprop's step size."""
    rollout: int = Field(8, ge=1)
    """Steps of each environment between two updates."""
    gae_lambda: float = Field(0.95, ge=0.0, le=1.0)
    """Trade-off of bias and variance in the advantages; 1 is the paper's."""
    entropy: float = Field(0.01, ge=0.0)
    """Weight of the entropy in the loss, which keeps exploration up."""
    value_weight: float = Field(0.5, ge=0.0)
    """Weight of the value's error in the loss."""
    gradient_clip: float = Field(0.5, gt=0.0)
    """Longest gradient, as a Euclidean norm, that is followed unshortened."""

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of the algorithm's constructor."""
        return super().arguments() | {
            "n_steps": self.rollout,
            "gae_lambda": self.gae_lambda,
            "ent_coef": self.entropy,
            "vf_coef": self.value_weight,
            "max_grad_norm": self.gradient_clip,
        }


train = trainer(KIND)
