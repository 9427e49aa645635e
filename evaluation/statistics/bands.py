"""Simultaneous confidence bands, which contain a whole mean curve and not just each of its steps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.statistics.estimate import CONFIDENCE, FEWEST, Maps
from indoor_explorers.evaluation.statistics.resampling import SmallSample, resampled_weights

#: Numbers of resampled curves, and weights of the resamples, in memory at a time.
IN_MEMORY, WEIGHTS = 2**22, 2**20
#: A standard deviation below this share of the largest value is rounding.
ROUNDING = 1e-12


class Band(NamedTuple):
    """A mean curve and its limits, each (T,); the limits are NaN where there are too few episodes."""

    mean: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


def curve_band(curves: NDArray[np.float64], *, maps: Maps = None, resamples: int = 2000) -> Band:
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
    return curve_bands([curves], maps=maps, resamples=resamples)[0]


def curve_bands(families: Sequence[NDArray[np.float64]], *, maps: Maps = None, resamples: int = 2000) -> list[Band]:
    """Return :func:`curve_band` of several (E, T) arrays of the same episodes, from one set of resamples."""
    if not families or len(families[0]) < FEWEST:
        means = [curves.mean(axis=0) for curves in families]
        return [Band(mean, np.full_like(mean, np.nan), np.full_like(mean, np.nan)) for mean in means]
    drawn = _resampled_curves(families, maps, resamples)
    sample = SmallSample.of(len(families[0]), maps)
    return [_band(curves, means, sample) for curves, means in zip(families, drawn, strict=True)]


def _band(curves: NDArray[np.float64], drawn: NDArray[np.float64], sample: SmallSample) -> Band:
    """Return the band of (E, T) curves from their (R, T) resampled means."""
    mean = curves.mean(axis=0)
    spread, largest = np.empty_like(mean), np.zeros(len(drawn))
    rounding = ROUNDING * max(curves.max(initial=0.0), -curves.min(initial=0.0))
    wide = max(1, IN_MEMORY // len(drawn))
    for start in range(0, curves.shape[1], wide):
        steps = slice(start, start + wide)
        deviation = drawn[:, steps].std(axis=0)
        moving = deviation > rounding
        spread[steps] = np.where(moving, deviation, 0.0)
        t = np.abs(drawn[:, steps] - mean[steps])[:, moving] / deviation[moving]
        largest = np.maximum(largest, t.max(axis=1, initial=0.0))
    width = sample.widened(float(np.quantile(largest, CONFIDENCE))) * spread
    return Band(mean, mean - width, mean + width)


def _resampled_curves(families: Sequence[NDArray[np.float64]], maps: Maps, resamples: int) -> list[NDArray[np.float64]]:
    """Return (R, T) resampled means of each family."""
    parts: list[list[NDArray[np.float64]]] = [[] for _ in families]
    for weights in _together(resampled_weights(len(families[0]), resamples, maps)):
        for part, curves in zip(parts, families, strict=True):
            part.append(weights @ curves)
    return [np.concatenate(part) for part in parts]


def _together(weights: Iterator[NDArray[np.float64]]) -> Iterator[NDArray[np.float64]]:
    """Yield the rows in larger chunks of about :data:`WEIGHTS` numbers."""
    waiting: list[NDArray[np.float64]] = []
    for chunk in weights:
        waiting.append(chunk)
        if len(waiting) * chunk.size >= WEIGHTS:
            yield np.concatenate(waiting)
            waiting = []
    if waiting:
        yield np.concatenate(waiting)
