"""What each ingredient of a learner is worth: train it without, several times, and compare on unseen maps."""

from indoor_explorers.evaluation.ablation.ablation import run_ablation

__all__ = ["run_ablation"]
