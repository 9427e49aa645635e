"""Ratios of means, such as how many times faster a team is than one UAV."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.statistics.estimate import FEWEST, RESAMPLES, Estimate, paired_values
from indoor_explorers.evaluation.statistics.resampling import resampled_weights
from indoor_explorers.evaluation.statistics.small_samples import SmallSample


def ratio_of_means(
    numerator: ArrayLike, denominator: ArrayLike, *, maps: ArrayLike | None = None, resamples: int = RESAMPLES
) -> Estimate:
    """Return mean(numerator) / mean(denominator) of (E,) values on the same tasks, with its interval.

    A resample takes both values of a task or none, so that what they share cancels. The ratio of means is not
    the mean of ratios, which a few quick episodes in the denominator would dominate (Davison & Hinkley 1997,
    Bootstrap Methods and their Application, example 1.2).

    Raises:
        InputError: the values are not pairs of finite numbers, there are none, or a denominator is not above 0.

    """
    above, below = paired_values(numerator, denominator)
    if not len(below) or (below <= 0).any():
        raise InputError("expected denominators above 0, got none or others; leave out what took no step")
    point = float(above.mean() / below.mean())
    if len(above) < FEWEST:
        return Estimate(point, None, None)
    drawn = [(weights @ above) / (weights @ below) for weights in resampled_weights(len(above), resamples, maps)]
    low, high = np.quantile(np.concatenate(drawn), SmallSample.of(len(above), maps).tails)
    return Estimate(point, float(low), float(high))
