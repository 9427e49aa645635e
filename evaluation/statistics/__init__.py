"""Statistics of paired episodes: estimates with intervals, bands, censored times, and comparisons.

Every policy flies the same tasks; arrays (E,) are episodes in the order of tasks, and ``maps`` (E,) labels the
map each was flown on. Resampling is seeded in each call: equal sample sizes give equal resamples for all
policies. ``evaluation/STATISTICS.md`` has the formulas and says what each number claims.
"""

from indoor_explorers.evaluation.statistics.bands import Band, curve_band, curve_bands
from indoor_explorers.evaluation.statistics.censoring import ecdf_of_times
from indoor_explorers.evaluation.statistics.contrasts import Contrast, Finding, contrasts
from indoor_explorers.evaluation.statistics.effects import effect_size, smallest_detectable_difference
from indoor_explorers.evaluation.statistics.equivalence import equivalence_test, units_to_resolve
from indoor_explorers.evaluation.statistics.estimate import CONFIDENCE, FEWEST, RESAMPLES, Estimate
from indoor_explorers.evaluation.statistics.means import (
    bootstrap_mean,
    bootstrap_means,
    interquartile_mean,
    paired_difference,
)
from indoor_explorers.evaluation.statistics.pairs import AllPairs, all_pairs_test, tied_ranks
from indoor_explorers.evaluation.statistics.profiles import performance_profile, performance_ratios
from indoor_explorers.evaluation.statistics.ratios import Block, PairedRatio, paired_ratios, ratio_of_means
from indoor_explorers.evaluation.statistics.resampling import maps_are_sampled, resampled_weights
from indoor_explorers.evaluation.statistics.seeds import difference_of_seeds, mean_of_seeds
from indoor_explorers.evaluation.statistics.significance import holm, sign_flip_test
from indoor_explorers.evaluation.statistics.successes import success_share, success_test, undetected_share
from indoor_explorers.evaluation.statistics.wins import WinTieLoss, probability_of_improvement, win_tie_loss

__all__ = [
    "CONFIDENCE",
    "FEWEST",
    "RESAMPLES",
    "AllPairs",
    "Band",
    "Block",
    "Contrast",
    "Estimate",
    "Finding",
    "PairedRatio",
    "WinTieLoss",
    "all_pairs_test",
    "bootstrap_mean",
    "bootstrap_means",
    "contrasts",
    "curve_band",
    "curve_bands",
    "difference_of_seeds",
    "ecdf_of_times",
    "effect_size",
    "equivalence_test",
    "holm",
    "interquartile_mean",
    "maps_are_sampled",
    "mean_of_seeds",
    "paired_difference",
    "paired_ratios",
    "performance_profile",
    "performance_ratios",
    "probability_of_improvement",
    "ratio_of_means",
    "resampled_weights",
    "sign_flip_test",
    "smallest_detectable_difference",
    "success_share",
    "success_test",
    "tied_ranks",
    "undetected_share",
    "units_to_resolve",
    "win_tie_loss",
]
