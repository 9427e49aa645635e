"""PPO of Stable-Baselines3 (Schulman et al. 2017, arXiv:1707.06347)."""

from __future__ import annotations

from typing import Any

from pydantic import Field
from stable_baselines3 import PPO
from stable_baselines3.common.policies import ActorCriticPolicy

from indoor_explorers.learners.baselines.config import PPOSettings
from indoor_explorers.learners.baselines.sb3_training import Sb3Algorithm, StableBaselinesConfig, logits, trainer

ALGORITHM = Sb3Algorithm("sb3-ppo", PPO, ActorCriticPolicy, logits)


class TrainingConfig(StableBaselinesConfig, PPOSettings):
    """The hyperparameters of PPO; all others have the library's defaults."""

    learning_rate: float = Field(5e-4, gt=0.0)
    """Adam's step size."""
    rollout: int = Field(64, ge=2)
    """Steps of each environment in one rollout; ``batch`` should divide ``rollout`` times ``environments``."""

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


train = trainer(ALGORITHM)
