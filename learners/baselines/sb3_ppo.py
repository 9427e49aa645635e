"""PPO of Stable-Baselines3: Schulman et al. 2017, arXiv:1707.06347."""

from __future__ import annotations

from typing import Any

from pydantic import Field
from stable_baselines3 import PPO
from stable_baselines3.common.policies import ActorCriticPolicy

from indoor_explorers.learners.baselines.sb3_training import (
    Kind,
    StableBaselinesConfig,
    logits,
    trainer,
)

KIND = Kind("sb3-ppo", PPO, ActorCriticPolicy, logits)


class TrainingConfig(StableBaselinesConfig):
    """Every hyperparameter of a PPO; those not named here are the library's own."""

    learning_rate: float = Field(5e-4, gt=0.0)
    """Adam's step size."""
    rollout: int = Field(64, ge=2)
    """Steps of each environment between two rounds of updates."""
    batch: int = Field(512, ge=2)
    """Moves in one update; divides ``environments`` times ``rollout`` best."""
    epochs: int = Field(4, ge=1)
    """How often each round goes through its moves."""
    gae_lambda: float = Field(0.95, ge=0.0, le=1.0)
    """Trade-off of bias and variance in the advantages (Schulman et al. 2016, arXiv:1506.02438)."""
    clip: float = Field(0.2, gt=0.0)
    """How far the ratio of new and old probabilities may leave 1 with gain."""
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
            "batch_size": self.batch,
            "n_epochs": self.epochs,
            "gae_lambda": self.gae_lambda,
            "clip_range": self.clip,
            "ent_coef": self.entropy,
            "vf_coef": self.value_weight,
            "max_grad_norm": self.gradient_clip,
        }


train = trainer(KIND)
