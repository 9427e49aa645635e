"""Whether two policies are as good as each other within a margin: two one-sided tests of the ratio of their means.

With a margin m, a policy is as good as another within m if neither mean is m or more above the other, as when the ratio
of means lies between 1 / (1 + m) and 1 + m. Each side is a mean of differences of single tasks, (1 + m) b - x and
(1 + m) x - b, which has to be above 0 (Schuirmann 1987, doi:10.1007/BF01068419).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from indoor_explorers.evaluation.statistics.effects import POWER, unit_spread
from indoor_explorers.evaluation.statistics.resampling import independent_units
from indoor_explorers.evaluation.statistics.significance import max_t_test


def equivalence_test(
    values: NDArray[np.float64],
    pairs: Sequence[tuple[int, int]],
    margin: float,
    *,
    maps: ArrayLike | None = None,
    reached: NDArray[np.bool_] | None = None,
) -> NDArray[np.float64]:
    """Return the (P,) p-values, adjusted for all ``pairs``, of "the means differ by ``margin`` or more".

    The larger of two one-sided sign-flip p-values counts. One side is half of the two-sided test of all sides of all
    pairs at once (``max_t_test``); with one pair this is close to two tests at 0.05, as by an interval of 90 %.

    Args:
        values: (E, K) steps of K policies on the same tasks, not negative.
        pairs: columns of the policies that are compared.
        margin: by which share a mean may exceed the other, above 0.
        maps: (E,) label of the map each task was flown on.
        reached: (E, K) whether each task was finished; tasks that one of a pair did not finish are left out of it.

    """
    if not pairs:
        return np.ones(0)
    one, other = np.array(pairs).T
    both = np.ones((len(values), len(pairs)), np.bool_) if reached is None else reached[:, one] & reached[:, other]
    sides = [within(values[:, x], values[:, b], margin) for x, b in ((one, other), (other, one))]
    units = independent_units(np.concatenate([np.where(both, side, 0.0) for side in sides], axis=1), maps)
    p = max_t_test(units).adjusted_p / 2
    return np.asarray(np.where(units.sum(axis=0) > 0, p, 1 - p).reshape(2, -1).max(axis=0))


def within(values: NDArray[np.float64], baseline: NDArray[np.float64], margin: float) -> NDArray[np.float64]:
    """Return what is tested of one side: by how much each value is below the margin above the baseline's."""
    return (1 + margin) * baseline - values


def units_to_resolve(
    values: NDArray[np.float64],
    baseline: NDArray[np.float64],
    margin: float,
    *,
    level: float,
    maps: ArrayLike | None = None,
) -> float:
    """Return how many maps or tasks would resolve what this sample leaves open, with 80 % power, if it is typical.

    If mean difference and spread are those observed, so many show a difference, or that the policies are as good within
    the margin, whichever is sooner: ``((t(1 - level / 2) + t(0.8)) s / mean)^2`` of the differences, or for both sides
    ``((t(1 - level) + t(0.9)) s / mean)^2``, with the mean of each side and s, the standard deviation of its units. It
    is more than this sample has, and NaN for fewer than two units.

    Args:
        values: (E,) steps of a policy.
        baseline: (E,) steps of the other on the same tasks.
        margin: by which share a mean may exceed the other.
        level: of a single test of the family.
        maps: (E,) label of the map each task was flown on; the answer counts maps where they are a sample.

    """
    units = len(independent_units(values, maps)) if len(values) else 0
    if units < 2:
        return math.nan
    apart = values - baseline
    sides = within(values, baseline, margin), within(baseline, values, margin)
    equal = max(_units_to_show(side, (1 - level, (1 + POWER) / 2), maps) for side in sides)
    different = _units_to_show(apart if apart.mean() > 0 else -apart, (1 - level / 2, POWER), maps)
    return max(units + 1.0, min(equal, different), math.ceil(1 - math.log2(level)))


def _units_to_show(sample: NDArray[np.float64], shares: tuple[float, float], maps: ArrayLike | None) -> float:
    """Return how many units show that the mean is above 0, by the quantiles of significance and power."""
    mean, spread = float(sample.mean()), unit_spread(sample, maps)
    if mean <= 0:
        return math.inf
    least = max(2, math.ceil((spread / mean * sum(float(special.ndtri(share)) for share in shares)) ** 2))
    counts = np.arange(least, least + 50, dtype=np.float64)  # Student's quantiles ask for a few more
    reach = np.asarray(sum(special.stdtrit(counts - 1, share) for share in shares))
    return float(counts[int((reach * spread <= mean * np.sqrt(counts)).argmax())])
