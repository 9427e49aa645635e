"""RLlib's discrete SAC for one UAV, or for a team with shared parameters.

Haarnoja et al. 2018, arXiv:1801.01290; for discrete actions Christodoulou 2019, arXiv:1910.07207. The target entropy
is set here because RLlib's automatic one is meant for continuous actions and lies below any entropy of five actions.
SAC trains without an action mask; evaluations and the policy take the best legal action.
"""

from __future__ import annotations

from pydantic import Field
from ray.rllib.algorithms.sac import SACConfig
from ray.rllib.algorithms.sac.torch.default_sac_torch_rl_module import DefaultSACTorchRLModule
from ray.rllib.core.rl_module.rl_module import RLModule

from indoor_explorers.learners.baselines.rllib_model import RllibConfig
from indoor_explorers.learners.baselines.rllib_training import trainer


class TrainingConfig(RllibConfig):
    """The hyperparameters of discrete SAC; all others have RLlib's defaults."""

    total_steps: int = Field(100_000, ge=1)
    """Moves made in training, all UAVs of all environments together; the last rollout may exceed it a little."""
    environments: int = Field(16, ge=1, le=4096)
    """Episodes flown in parallel."""
    learning_rate: float = Field(3e-4, gt=0.0)
    """Adam's step size for actor, critics and temperature."""
    batch: int = Field(256, ge=1)
    """Transitions in one update."""
    intensity: float = Field(16.0, gt=0.0)
    """Replayed transitions per move made."""
    replay_steps: int = Field(50_000, ge=1)
    """Size of the replay buffer in moves; checkpoints do not contain it."""
    priority: float = Field(0.6, ge=0.0)
    """Exponent of the TD error in the replay priority, alpha; 0 is uniform (Schaul et al. 2016, arXiv:1511.05952)."""
    correction: float = Field(0.4, ge=0.0)
    """Exponent of the importance-sampling weights, beta; 1 corrects the priorities fully."""
    warmup_steps: int = Field(2_000, ge=0)
    """Moves made before the first update."""
    return_steps: int = Field(3, ge=1, le=100)
    """Steps of the n-step return."""
    target_rate: float = Field(0.005, gt=0.0, le=1.0)
    """Rate tau of the soft target updates."""
    temperature: float = Field(0.1, gt=0.0)
    """Initial weight of the entropy; it is learned."""
    target_entropy: float = Field(0.3, ge=0.0)
    """Target entropy in nats; that of five equally likely actions is 1.61."""

    def module(self) -> type[RLModule]:
        """Return the class of the network."""
        return DefaultSACTorchRLModule

    def algorithm(self) -> SACConfig:
        """Return RLlib's configuration of the algorithm with these hyperparameters."""
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
        description.lr = None  # type: ignore[assignment]  # RLlib demands None, as SAC has three rates of its own
        return description.reporting(min_time_s_per_iteration=0)


train = trainer("rllib-sac")
