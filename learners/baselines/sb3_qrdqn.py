"""QR-DQN of sb3-contrib: a DQN that learns quantiles of the return (Dabney et al. 2018, arXiv:1710.10044).

Like the DQN it knows no action mask; in evaluation and as a policy the legal action of best mean is flown.
"""

from __future__ import annotations

from typing import Any

import torch
from pydantic import Field
from sb3_contrib import QRDQN
from sb3_contrib.qrdqn.policies import QRDQNPolicy

from indoor_explorers.learners.baselines import sb3_dqn
from indoor_explorers.learners.baselines.sb3_training import Kind, trainer


def means(policy: QRDQNPolicy, rows: torch.Tensor) -> torch.Tensor:
    """Return the mean of each action's quantiles."""
    found: torch.Tensor = policy.quantile_net(rows).mean(dim=1)
    return found


KIND = Kind("sb3-qrdqn", QRDQN, QRDQNPolicy, means)


class TrainingConfig(sb3_dqn.TrainingConfig):
    """Every hyperparameter of a QR-DQN: those of the DQN, and the quantiles."""

    quantiles: int = Field(25, ge=1)
    """Quantiles of each action's return; the paper has 200 for Atari games."""

    def network(self) -> dict[str, Any]:
        """Return the arguments of the network's constructor."""
        return super().network() | {"n_quantiles": self.quantiles}


train = trainer(KIND)
