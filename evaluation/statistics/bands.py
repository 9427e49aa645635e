"""Simultaneous confidence bands, which contain a whole mean curve and not just each of its steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.evaluation.statistics.estimate import CONFIDENCE, FEWEST
from indoor_explorers.evaluation.statistics.resampling import resampled_weights
from indoor_explorers.evaluation.statistics.small_samples import SmallSample

#: Numbers of resampled curves, and weights of the resamples, in memory at a time.
IN_MEMORY, WEIGHTS = 2**22, 2**21
#: A standard deviation below this share of the largest value is rounding.
ROUNDING = 1e-12


def curve_band(
    curves: NDArray[np.float64], *, maps: ArrayLike | None = None, resamples: int = 2000
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return (mean, low, high), each (T,), of (E, T) curves: a simultaneous 95 % band of the mean curve.

    With 95 % confidence the true mean curve lies inside at all steps at once. The band is
    ``mean +- c * s``: s is the bootstrap standard deviation of the mean at each step and c the 95 % quantile of
    the largest ``|resampled mean - mean| / s`` over the steps (the sup-t band of Montiel Olea & Plagborg-Moller
    2019, algorithm 1, doi:10.1002/jae.2656). Steps at which s is 0 have no width and do not count for c.

    Whole episodes are drawn, so that a resample keeps each curve in one piece. The band is not clipped: near
    0 and 1 it can leave the range of the curves, and clipping it to that range loses no coverage. With fewer
    than :data:`~indoor_explorers.evaluation.statistics.estimate.FEWEST` episodes, low and high are NaN.

    Args:
        curves: (E, T) coverage by step.
        maps: (E,) label of the map each episode was flown on.
        resamples: number of resamples.

    Raises:
        InputError: ``maps`` does not have one label for each episode.

    """
    mean = curves.mean(axis=0)
    if len(curves) < FEWEST:
        return mean, np.full_like(mean, np.nan), np.full_like(mean, np.nan)
    spread, largest = np.empty_like(mean), np.zeros(resamples)
    rounding = ROUNDING * max(curves.max(initial=0.0), -curves.min(initial=0.0))
    drawn = _resampled_curves(curves, maps, resamples)
    wide = max(1, IN_MEMORY // resamples)
    for start in range(0, curves.shape[1], wide):
        steps = slice(start, start + wide)
        deviation = drawn[:, steps].std(axis=0)
        moving = deviation > rounding
        spread[steps] = np.where(moving, deviation, 0.0)
        t = np.abs(drawn[:, steps] - mean[steps])[:, moving] / deviation[moving]
        largest = np.maximum(largest, t.max(axis=1, initial=0.0))
    multiplier = float(np.quantile(largest, CONFIDENCE))
    width = SmallSample.of(len(curves), maps).widened(multiplier) * spread
    return mean, mean - width, mean + width


def _resampled_curves(curves: NDArray[np.float64], maps: ArrayLike | None, resamples: int) -> NDArray[np.float64]:
    """Return (R, T) resampled means."""
    parts, waiting = [], []
    for weights in resampled_weights(len(curves), resamples, maps):
        waiting.append(weights)
        if len(waiting) * weights.size >= WEIGHTS:
            parts.append(np.concatenate(waiting) @ curves)
            waiting = []
    return np.concatenate([*parts, *([np.concatenate(waiting) @ curves] if waiting else [])])
