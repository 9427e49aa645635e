"""Statistics of paired episodes: means with bootstrap intervals, interquartile means, paired differences.

Every policy flies the same tasks, and a bootstrap draws whole episodes with the same indices for all of
them: the generator is seeded anew for each call, so that equal sample sizes give equal resamples. Fewer
than :data:`FEWEST` episodes get no interval.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

FEWEST = 5
RESAMPLES = 10_000
CONFIDENCE = 0.95


class Estimate(NamedTuple):
    """A mean with its interval; ``low`` and ``high`` are None where there are too few episodes."""

    mean: float
    low: float | None
    high: float | None


def _resamples(count: int, resamples: int) -> NDArray[np.int64]:
    """Return (resamples, count) episode indices, the same for every call of equal size."""
    return np.random.default_rng(0).integers(0, count, (resamples, count))


def bootstrap_mean(values: ArrayLike, *, resamples: int = RESAMPLES) -> Estimate:
    """Return the mean of (E,) episode values with its 95 % percentile bootstrap interval."""
    sample = np.asarray(values, np.float64)
    mean = float(sample.mean())
    if len(sample) < FEWEST:
        return Estimate(mean, None, None)
    means = sample[_resamples(len(sample), resamples)].mean(axis=1)
    low, high = np.quantile(means, _tails())
    return Estimate(mean, float(low), float(high))


def paired_difference(values: ArrayLike, baseline: ArrayLike, *, resamples: int = RESAMPLES) -> Estimate:
    """Return the mean of ``values - baseline``, both (E,) over the same tasks, with its interval."""
    return bootstrap_mean(np.asarray(values, np.float64) - np.asarray(baseline, np.float64), resamples=resamples)


def interquartile_mean(values: ArrayLike) -> float:
    """Return the mean of the middle half of (E,) values (Agarwal et al. 2021)."""
    return float(stats.trim_mean(np.asarray(values, np.float64), 0.25))


def curve_band(curves: NDArray[np.float64], *, resamples: int = 2000) -> tuple[NDArray[np.float64], ...]:
    """Return (mean, low, high), each (T,), of (E, T) curves: pointwise 95 % bootstrap intervals of the mean.

    Whole episodes are drawn, so a resample keeps each curve in one piece. With fewer than
    :data:`FEWEST` episodes, low and high are NaN.
    """
    mean = curves.mean(axis=0)
    if len(curves) < FEWEST:
        return mean, np.full_like(mean, np.nan), np.full_like(mean, np.nan)
    draws = _resamples(len(curves), resamples)
    weights = np.apply_along_axis(np.bincount, 1, draws, minlength=len(curves)) / len(curves)
    low, high = np.quantile(weights @ curves, _tails(), axis=0)
    return mean, low, high


def _tails() -> tuple[float, float]:
    return (1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2
