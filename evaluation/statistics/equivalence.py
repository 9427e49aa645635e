"""Whether two policies are as good as each other within a margin: two one-sided tests of the ratio of their means.

With a margin m, a policy is as good as another within m if neither mean is m or more above the other, as when the ratio
of means lies between 1 / (1 + m) and 1 + m. Each side is a mean of differences of single tasks, (1 + m) b - x and
(1 + m) x - b, which has to be above 0 (Schuirmann 1987, doi:10.1007/BF01068419).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import special

from indoor_explorers.evaluation.statistics.effects import POWER, unit_spread
from indoor_explorers.evaluation.statistics.estimate import FEWEST, Maps
from indoor_explorers.evaluation.statistics.resampling import independent_units
from indoor_explorers.evaluation.statistics.significance import holm

#: Numbers of units that are tried.
COUNTS = np.unique(np.geomspace(2, 1e7, 800).round())


def equivalence_test(
    values: NDArray[np.float64],
    pairs: Sequence[tuple[int, int]],
    margin: float,
    *,
    maps: Maps = None,
    reached: NDArray[np.bool_] | None = None,
) -> NDArray[np.float64]:
    """Return the (P,) p-values, adjusted for all ``pairs``, of "the means differ by ``margin`` or more".

    The larger of two one-sided p-values counts, each of Student's t of the independent units, and Holm's method adjusts
    it. For one pair this is to ask whether an interval of 90 % is within the margin. Fewer than five units show
    nothing.

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
    return holm(np.maximum(*(_above_zero(np.where(both, side, 0.0), maps) for side in sides)))


def _above_zero(side: NDArray[np.float64], maps: Maps) -> NDArray[np.float64]:
    """Return the (P,) one-sided p-values that the means of (E, P) values are above 0."""
    units = independent_units(side, maps)
    if len(units) < FEWEST:
        return np.ones(side.shape[1])
    error = units.std(axis=0, ddof=1) / math.sqrt(len(units))
    t = units.mean(axis=0) / np.maximum(error, 1e-12)
    return np.asarray(special.stdtr(len(units) - 1, -t))


def within(values: NDArray[np.float64], baseline: NDArray[np.float64], margin: float) -> NDArray[np.float64]:
    """Return what is tested of one side: by how much each value is below the margin above the baseline's."""
    return (1 + margin) * baseline - values


def units_to_resolve(
    values: NDArray[np.float64],
    baseline: NDArray[np.float64],
    margin: float,
    *,
    level: float,
    maps: Maps = None,
) -> float:
    """Return how many maps or tasks would resolve what this sample leaves open, with 80 % power, if it is typical.

    If mean difference and spread are those observed, a t test of that many units shows a difference, or two tests show
    equivalence within the margin, whichever needs fewer. The number is above that of this sample, exact up to about 50,
    and NaN for fewer than two units.

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
    equal = _units_to_show((within(values, baseline, margin), within(baseline, values, margin)), level, maps)
    different = _units_to_show((apart if apart.mean() > 0 else -apart,), level / 2, maps)
    return max(units + 1.0, min(equal, different), math.ceil(1 - math.log2(level)))


def _units_to_show(samples: Sequence[NDArray[np.float64]], level: float, maps: Maps) -> float:
    """Return how many units show that the means of all samples are above 0, infinite where none do."""
    missed = np.zeros(len(COUNTS))
    for sample in samples:
        far = float(sample.mean()) / max(unit_spread(sample, maps), 1e-9) * np.sqrt(COUNTS)
        missed += special.stdtr(COUNTS - 1, special.stdtrit(COUNTS - 1, 1 - level) - far)
    enough = missed <= 1 - POWER
    return float(COUNTS[enough.argmax()]) if enough.any() else math.inf
