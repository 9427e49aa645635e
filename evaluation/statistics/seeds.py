"""Means over trainings and episodes, both of which vary: other seeds train other networks, other maps need more steps.

S trainings of a variant each fly the same E episodes. The mean of all varies with the trainings, by the spread of
their means over S, and with the episodes, by the spread of the episodes' means over E. The two variances are added,
which is at worst a little too wide, since the interaction of training and episode is in both (Owen 2007, The
pigeonhole bootstrap, section 3, doi:10.1214/07-AOAS122). The interval is Student's, its degrees of freedom those of
Satterthwaite (1946, doi:10.2307/3002019). Between two variants the difference is taken episode by episode.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import special

from indoor_explorers.evaluation.statistics.estimate import CONFIDENCE, FEWEST, Estimate

#: The fewest trainings of a variant that give an interval.
FEWEST_SEEDS = 2


def mean_of_seeds(values: NDArray[np.float64]) -> Estimate:
    """Return the mean of (S, E) values of S trainings on E episodes, with its 95 % interval."""
    return _estimate([values], values.mean(axis=0))


def difference_of_seeds(values: NDArray[np.float64], baseline: NDArray[np.float64]) -> Estimate:
    """Return the mean of (S, E) ``values`` less that of (S', E) ``baseline`` on the same episodes, with its interval.

    The interval is left out where there are fewer than two trainings of either, or fewer than five episodes.
    """
    return _estimate([values, baseline], values.mean(axis=0) - baseline.mean(axis=0))


def _estimate(samples: list[NDArray[np.float64]], by_episode: NDArray[np.float64]) -> Estimate:
    point = float(by_episode.mean())
    if len(by_episode) < FEWEST or min(map(len, samples)) < FEWEST_SEEDS:
        return Estimate(point, None, None)
    units = [by_episode, *(sample.mean(axis=1) for sample in samples)]
    variances = [float(unit.var(ddof=1)) / len(unit) for unit in units]
    total = sum(variances)
    if total == 0.0:
        return Estimate(point, point, point)
    spread = sum(variance**2 / (len(unit) - 1) for variance, unit in zip(variances, units, strict=True))
    reach = math.sqrt(total) * float(special.stdtrit(total**2 / spread, (1 + CONFIDENCE) / 2))
    return Estimate(point, point - reach, point + reach)
