"""DQN of Stable-Baselines3 (Mnih et al. 2015, doi:10.1038/nature14236) with n-step returns.

The library's DQN is neither double nor dueling, replays uniformly, and has no action mask: it learns what illegal
moves cost. Evaluations and the policy take the best legal action.
"""

from __future__ import annotations

from typing import Any

import torch
from pydantic import Field
from stable_baselines3 import DQN
from stable_baselines3.common.buffers import NStepReplayBuffer
from stable_baselines3.dqn.policies import DQNPolicy

from indoor_explorers.learners.baselines.sb3_training import Sb3Algorithm, StableBaselinesConfig, trainer


def values(policy: DQNPolicy, rows: torch.Tensor) -> torch.Tensor:
    """Return the action values (B, 5) for observations (B, D)."""
    found: torch.Tensor = policy.q_net(rows)
    return found


ALGORITHM = Sb3Algorithm("sb3-dqn", DQN, DQNPolicy, values)


class TrainingConfig(StableBaselinesConfig):
    """The hyperparameters of DQN; all others have the library's defaults."""

    total_steps: int = Field(500_000, ge=1)
    """Moves made in training, all environments together."""
    environments: int = Field(16, ge=1, le=4096)
    """Episodes flown in parallel; after each step of all of them the network is updated ``updates`` times."""
    updates: int = Field(2, ge=1, le=1024)
    """Updates of the network after each step of all environments."""
    batch: int = Field(128, ge=1)
    """Transitions in one update."""
    replay_steps: int = Field(50_000, ge=1)
    """Size of the replay buffer in moves; each takes some 10 kB of memory, and of every checkpoint."""
    warmup_steps: int = Field(5_000, ge=0)
    """Moves made before the first update."""
    return_steps: int = Field(3, ge=1, le=100)
    """Steps of the n-step return."""
    target_every: int = Field(4_000, ge=1)
    """Moves between two updates of the target network."""
    epsilon_first: float = Field(1.0, ge=0.0, le=1.0)
    """Initial probability of a random move, illegal ones included."""
    epsilon_last: float = Field(0.02, ge=0.0, le=1.0)
    """Final probability of a random move."""
    epsilon_share: float = Field(0.3, gt=0.0, le=1.0)
    """Share of the training over which that probability falls linearly."""
    gradient_clip: float = Field(10.0, gt=0.0)
    """Largest Euclidean norm of a gradient; a longer one is scaled down to it."""

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of the algorithm's constructor."""
        return super().arguments() | {
            "train_freq": 1,
            "gradient_steps": self.updates,
            "batch_size": self.batch,
            "buffer_size": self.replay_steps,
            "learning_starts": self.warmup_steps,
            "replay_buffer_class": NStepReplayBuffer,
            "replay_buffer_kwargs": {"n_steps": self.return_steps, "gamma": self.gamma},
            "target_update_interval": self.target_every,
            "exploration_initial_eps": self.epsilon_first,
            "exploration_final_eps": self.epsilon_last,
            "exploration_fraction": self.epsilon_share,
            "max_grad_norm": self.gradient_clip,
        }


train = trainer(ALGORITHM)
