"""QR-DQN of sb3-contrib: a DQN that learns quantiles of the return (Dabney et al. 2018, arXiv:1710.10044).

Like the DQN it has no action mask; evaluations and the policy take the legal action of highest mean.
"""

from __future__ import annotations

from typing import Any

import torch
from pydantic import Field
from sb3_contrib import QRDQN
from sb3_contrib.qrdqn.policies import QRDQNPolicy

from indoor_explorers.learners.baselines import sb3_dqn
from indoor_explorers.learners.baselines.sb3_training import Sb3Algorithm, trainer


def means(policy: QRDQNPolicy, rows: torch.Tensor) -> torch.Tensor:
    """Return the means of the actions' quantiles (B, 5) for observations (B, D)."""
    found: torch.Tensor = policy.quantile_net(rows).mean(dim=1)
    return found


ALGORITHM = Sb3Algorithm("sb3-qrdqn", QRDQN, QRDQNPolicy, means)


class TrainingConfig(sb3_dqn.TrainingConfig):
    """The hyperparameters of QR-DQN: those of DQN, and the number of quantiles."""

    quantiles: int = Field(25, ge=1)
    """Quantiles of each action's return; the paper uses 200 for Atari games."""

    def network(self) -> dict[str, Any]:
        """Return the arguments of the network's constructor."""
        return super().network() | {"n_quantiles": self.quantiles}


train = trainer(ALGORITHM)
