"""Means, interquartile means and paired differences, with percentile bootstrap intervals.

Whole episodes are drawn as :mod:`~indoor_explorers.evaluation.statistics.resampling` says, with the same
resamples for all policies. The interval lies between two quantiles of the resampled statistic (Efron & Tibshirani
1993, An Introduction to the Bootstrap, section 13.3): 2.5 % and 97.5 % for many units, and more extreme ones for few,
see :class:`~indoor_explorers.evaluation.statistics.resampling.SmallSample`.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.evaluation.statistics.estimate import (
    FEWEST,
    RESAMPLES,
    Estimate,
    Maps,
    episode_values,
    paired_values,
)
from indoor_explorers.evaluation.statistics.resampling import SmallSample, resampled_weights

#: Share of the episodes that an interquartile mean leaves out at each end.
TRIMMED = 0.25


def bootstrap_mean(values: ArrayLike, *, resamples: int = RESAMPLES, maps: Maps = None) -> Estimate:
    """Return the mean of (E,) episode values with its 95 % bootstrap interval; NaN for no episodes at all.

    Args:
        values: (E,), in the same order of tasks for every policy.
        resamples: number of resamples.
        maps: (E,) label of the map each episode was flown on.

    Raises:
        InputError: ``values`` or ``maps`` do not have one finite number or label for each episode.

    """
    return bootstrap_means(episode_values(values)[:, None], resamples=resamples, maps=maps)[0]


def bootstrap_means(columns: NDArray[np.float64], *, resamples: int = RESAMPLES, maps: Maps = None) -> list[Estimate]:
    """Return :func:`bootstrap_mean` of each column of (E, K) values, from one set of resamples."""
    if not len(columns):
        return [Estimate(float("nan"), None, None)] * columns.shape[1]
    means = columns.mean(axis=0)
    if len(columns) < FEWEST:
        return [Estimate(mean, None, None) for mean in means.tolist()]
    apart = columns - means  # equal values then give an interval without width
    drawn = np.concatenate([means + weights @ apart for weights in resampled_weights(len(columns), resamples, maps)])
    lows, highs = np.quantile(drawn, SmallSample.of(len(columns), maps).tails, axis=0)
    return [Estimate(*three) for three in zip(means.tolist(), lows.tolist(), highs.tolist(), strict=True)]


def means_of_measured(values: Mapping[str, NDArray[np.float64]], maps: NDArray[np.str_]) -> dict[str, Estimate]:
    """Return the mean of each (E,) column over the episodes that have a value, NaN for none, with its interval.

    Columns without NaN share one set of resamples; columns of NaN alone are left out.
    """
    held = {name: ~np.isnan(column) for name, column in values.items()}
    whole = [name for name in values if held[name].all()]
    found = dict(zip(whole, bootstrap_means(np.stack([values[n] for n in whole], axis=1), maps=maps), strict=True))
    for name, there in held.items():
        if there.any() and name not in found:
            found[name] = bootstrap_mean(values[name][there], maps=maps[there])
    return {name: found[name] for name in values if name in found}


def interquartile_mean(values: ArrayLike) -> float:
    """Return the mean of the middle half of (E,) values (Agarwal et al. 2021, arXiv:2108.13264, section 4.3)."""
    sample = np.asarray(values, np.float64)
    if not len(sample):
        return float("nan")
    cut = int(TRIMMED * len(sample))
    return float(np.partition(sample, (cut, len(sample) - cut - 1))[cut : len(sample) - cut].mean())


def paired_difference(
    values: ArrayLike, baseline: ArrayLike, *, resamples: int = RESAMPLES, maps: Maps = None
) -> Estimate:
    """Return the mean of ``values - baseline``, both (E,) over the same tasks, with its interval.

    Raises:
        InputError: the values are not pairs of finite numbers.

    """
    ours, theirs = paired_values(values, baseline)
    return bootstrap_mean(ours - theirs, resamples=resamples, maps=maps)
