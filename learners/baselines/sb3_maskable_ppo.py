"""MaskablePPO of sb3-contrib: PPO with an action mask (Huang and Ontanon 2022, arXiv:2006.14171)."""

from __future__ import annotations

from sb3_contrib import MaskablePPO
from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy

from indoor_explorers.learners.baselines import sb3_ppo
from indoor_explorers.learners.baselines.sb3_training import Sb3Algorithm, logits, trainer

ALGORITHM = Sb3Algorithm("sb3-maskable-ppo", MaskablePPO, MaskableActorCriticPolicy, logits)


class TrainingConfig(sb3_ppo.TrainingConfig):
    """The hyperparameters of MaskablePPO: those of PPO."""


train = trainer(ALGORITHM)
