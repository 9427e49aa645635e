"""Effect size of a difference, and the smallest difference that a test would detect."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.statistics.estimate import CONFIDENCE, Maps, episode_values
from indoor_explorers.evaluation.statistics.resampling import independent_units

#: Power of the smallest detectable difference.
POWER = 0.8


def effect_size(differences: ArrayLike) -> float:
    """Return the mean of (E,) paired differences in standard deviations of them: Cohen's d_z, corrected.

    ``d_z = J * mean / s`` with s over n - 1 and Hedges' correction ``J = G(m / 2) / (sqrt(m / 2) G((m - 1) / 2))``,
    m = n - 1, G the gamma function; without it, the effect size of few pairs is too large (Hedges 1981,
    doi:10.3102/10769986006002107; Lakens 2013, doi:10.3389/fpsyg.2013.00863). It is 0 when all differences are 0,
    and NaN where it is not defined: fewer than 3 pairs, or differences that are all the same and not 0.

    Raises:
        InputError: there is not one finite difference for each episode.

    """
    sample = episode_values(differences)
    if len(sample) < 3:
        return math.nan
    mean, spread = float(sample.mean()), float(sample.std(ddof=1))
    if spread <= 1e-12 * abs(mean):
        return 0.0 if mean == 0 else math.nan
    m = len(sample) - 1
    correction = math.exp(special.gammaln(m / 2) - special.gammaln((m - 1) / 2)) / math.sqrt(m / 2)
    return correction * mean / spread


def smallest_detectable_difference(
    differences: ArrayLike, *, power: float = POWER, level: float = 1 - CONFIDENCE, maps: Maps = None
) -> float:
    """Return the smallest true mean difference that a paired two-sided test detects with this power.

    ``(t(1 - level / 2) + t(power)) * s / sqrt(n)``, t the quantiles of Student's distribution with n - 1 degrees
    of freedom, n and s the number and the standard deviation of the independent units: maps where these are a sample,
    else episodes (:func:`unit_spread`; Bloom 1995, doi:10.1177/0193841X9501900504). Where a difference is not
    significant, true ones up to about this size may well exist. The observed spread is taken as the true one.

    Infinite where no difference of any size can be detected: one unit, or so few that the sign-flip test's
    smallest p-value, 2 / 2^n, is above the level.

    Args:
        differences: (E,) policy minus baseline on the same tasks.
        power: probability of detecting it, between 0 and 1.
        level: the test's probability of a false positive.
        maps: (E,) label of the map each was flown on.

    Raises:
        InputError: power or level is not a probability between 0 and 1, or a difference not finite.

    """
    if not (0 < power < 1 and 0 < level < 1):
        raise InputError(f"expected power and level between 0 and 1, got {power:g} and {level:g}; pass 0.8 and 0.05")
    sample = episode_values(differences)
    count = len(independent_units(sample, maps))
    if count < 2 or 2.0 ** (1 - count) > level:
        return math.inf
    found, missed = (float(special.stdtrit(count - 1, share)) for share in (1 - level / 2, power))
    return (found + missed) * unit_spread(sample, maps) / math.sqrt(count)


def unit_spread(sample: NDArray[np.float64], maps: Maps = None) -> float:
    """Return the standard deviation of the independent units of (E,) values about their mean; NaN for fewer than two.

    Over the root of their number it is the standard error of the mean over episodes; of maps with one episode each, and
    with equally many, it is that of the maps' means.
    """
    units = independent_units(sample - sample.mean(), maps) if len(sample) else sample
    return math.sqrt(float((units**2).sum()) / (len(units) - 1)) if len(units) > 1 else math.nan
