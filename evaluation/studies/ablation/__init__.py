"""Ablation: train a learner without each of its ingredients, several times, and compare on unseen maps."""

from indoor_explorers.evaluation.studies.ablation.ablation import run_ablation

__all__ = ["run_ablation"]
