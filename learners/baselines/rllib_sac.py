"""Discrete SAC of RLlib for a team with shared parameters, or for one UAV.

Haarnoja et al. 2018, arXiv:1801.01290; for discrete actions Christodoulou 2019, arXiv:1910.07207. The library's
automatic target entropy is that of continuous actions, below any entropy of five actions, so one is given here. It
knows no action mask; in evaluation and as a policy the best legal action is flown.
"""

from __future__ import annotations

from pydantic import Field
from ray.rllib.algorithms.sac import SACConfig
from ray.rllib.algorithms.sac.torch.default_sac_torch_rl_module import DefaultSACTorchRLModule
from ray.rllib.core.rl_module.rl_module import RLModule

from indoor_explorers.learners.baselines.rllib_model import RllibConfig
from indoor_explorers.learners.baselines.rllib_training import trainer


class TrainingConfig(RllibConfig):
    """Every hyperparameter of a discrete SAC; those not named here are the library's own."""

    total_steps: int = Field(100_000, ge=1)
    """Moves made in training, all UAVs of all environments together; the last round may go a little beyond."""
    environments: int = Field(16, ge=1, le=4096)
    """Episodes flown side by side."""
    learning_rate: float = Field(3e-4, gt=0.0)
    """Adam's step size for actor, critics and temperature."""
    batch: int = Field(256, ge=1)
    """Transitions in one update."""
    intensity: float = Field(16.0, gt=0.0)
    """Transitions learned from for each one flown, those of a batch counted each."""
    replay_steps: int = Field(50_000, ge=1)
    """Latest moves kept for replay, which checkpoints leave out."""
    priority: float = Field(0.6, ge=0.0)
    """How much more often what was badly predicted is replayed; 0: all alike (Schaul et al. 2016, arXiv:1511.05952)."""
    correction: float = Field(0.4, ge=0.0)
    """How far its weight in the loss makes up for that; 1: wholly."""
    warmup_steps: int = Field(2_000, ge=0)
    """Steps flown before the first update."""
    return_steps: int = Field(3, ge=1, le=100)
    """Rewards summed before the network's own estimate takes over."""
    target_rate: float = Field(0.005, gt=0.0, le=1.0)
    """Share of the way that the target networks move to the critics after each update."""
    temperature: float = Field(0.1, gt=0.0)
    """Weight of the entropy at the beginning; it is learned."""
    target_entropy: float = Field(0.3, ge=0.0)
    """Entropy in nats that the temperature aims at; that of five equal actions is 1.61."""

    def module(self) -> type[RLModule]:
        """Return the class of the network."""
        return DefaultSACTorchRLModule

    def algorithm(self) -> SACConfig:
        """Return the library's description of the algorithm with these hyperparameters."""
        description = SACConfig().training(
            gamma=self.gamma,
            actor_lr=self.learning_rate,
            critic_lr=self.learning_rate,
            alpha_lr=self.learning_rate,
            train_batch_size_per_learner=self.batch,
            training_intensity=self.intensity,
            replay_buffer_config={
                "type": "MultiAgentPrioritizedEpisodeReplayBuffer",
                "capacity": self.replay_steps,
                "alpha": self.priority,
                "beta": self.correction,
            },
            num_steps_sampled_before_learning_starts=self.warmup_steps,
            n_step=self.return_steps,
            tau=self.target_rate,
            initial_alpha=self.temperature,
            target_entropy=self.target_entropy,
        )
        description.lr = None  # type: ignore[assignment]  # RLlib asks for it: SAC has three of its own
        return description.reporting(min_time_s_per_iteration=0)


train = trainer("rllib-sac")
