"""RLlib's PPO (Schulman et al. 2017, arXiv:1707.06347) for one UAV, or for a team with shared parameters."""

from __future__ import annotations

from pydantic import Field
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.algorithms.ppo.torch.default_ppo_torch_rl_module import DefaultPPOTorchRLModule
from ray.rllib.core.rl_module.rl_module import RLModule

from indoor_explorers.learners.baselines.config import PPOSettings
from indoor_explorers.learners.baselines.rllib_model import MaskedPPOModule, RllibConfig
from indoor_explorers.learners.baselines.rllib_training import trainer


class TrainingConfig(RllibConfig, PPOSettings):
    """The hyperparameters of PPO; all others have RLlib's defaults."""

    total_steps: int = Field(500_000, ge=1)
    """Moves made in training, all UAVs of all environments together; the last rollout may exceed it a little."""
    environments: int = Field(16, ge=1, le=4096)
    """Episodes flown in parallel."""
    mask: bool = True
    """Whether the network gets the action mask and never draws an illegal move."""
    learning_rate: float = Field(5e-4, gt=0.0)
    """Adam's step size."""
    rollout: int = Field(2048, ge=2)
    """Steps of all environments together in one rollout."""
    value_clip: float = Field(100.0, gt=0.0)
    """Largest squared value error that counts in the loss."""

    @property
    def masked(self) -> bool:
        """Whether the network gets the action mask and never draws an illegal move."""
        return self.mask

    def module(self) -> type[RLModule]:
        """Return the class of the network."""
        return MaskedPPOModule if self.mask else DefaultPPOTorchRLModule

    def algorithm(self) -> PPOConfig:
        """Return RLlib's configuration of the algorithm with these hyperparameters."""
        return PPOConfig().training(
            lr=self.learning_rate,
            gamma=self.gamma,
            train_batch_size_per_learner=self.rollout,
            minibatch_size=self.batch,
            num_epochs=self.epochs,
            lambda_=self.gae_lambda,
            clip_param=self.clip,
            vf_clip_param=self.value_clip,
            entropy_coeff=self.entropy,
            vf_loss_coeff=self.value_weight,
            grad_clip=self.gradient_clip,
            use_kl_loss=False,
        )


train = trainer("rllib-ppo")
