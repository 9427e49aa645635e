"""MaskablePPO of sb3-contrib: PPO that never draws an illegal move (Huang and Ontanon 2022, arXiv:2006.14171)."""

from __future__ import annotations

from sb3_contrib import MaskablePPO
from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy

from indoor_explorers.learners.baselines import sb3_ppo
from indoor_explorers.learners.baselines.sb3_training import Kind, logits, trainer

KIND = Kind("sb3-maskable-ppo", MaskablePPO, MaskableActorCriticPolicy, logits)


class TrainingConfig(sb3_ppo.TrainingConfig):
    """Every hyperparameter of a MaskablePPO: those of the PPO."""


train = trainer(KIND)
