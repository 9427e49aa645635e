"""Studies that train variants of a learner, several times each, and compare them on unseen maps."""

from indoor_explorers.evaluation.studies.variants.ablation import run_ablation
from indoor_explorers.evaluation.studies.variants.scaling import run_scaling

__all__ = ["run_ablation", "run_scaling"]
