"""MaskablePPO of sb3-contrib: PPO that never draws an illegal move (Huang and Ontanon 2022, arXiv:2006.14171)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from sb3_contrib import MaskablePPO
from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy

from indoor_explorers.env.scenario import Scenario
from indoor_explorers.learners.baselines import sb3_ppo
from indoor_explorers.learners.baselines.sb3_training import Kind, logits, train_stable_baselines
from indoor_explorers.learners.baselines.session import Progress

KIND = Kind("sb3-maskable-ppo", MaskablePPO, MaskableActorCriticPolicy, logits)


class TrainingConfig(sb3_ppo.TrainingConfig):
    """Every hyperparameter of a MaskablePPO: those of the PPO."""


def train(
    config: TrainingConfig,
    scenario: Scenario,
    out: Path,
    *,
    seed: int,
    resume: bool = False,
    report: Callable[[Progress], None] | None = None,
) -> Path:
    """Train a MaskablePPO on one UAV, see :func:`train_stable_baselines`."""
    return train_stable_baselines(KIND, config, scenario, out, seed=seed, resume=resume, report=report)
