"""Correction of intervals for few units, which makes them wider.

A percentile bootstrap interval over n units is too narrow for small n: the variance of its resamples is too small
by (n - 1) / n, and their distribution is not Student's. The expanded percentile interval takes more extreme quantiles
of the same resamples, chosen so that the mean of normal values gets the width of its t interval (Hesterberg
2015, The American Statistician 69:371, doi:10.1080/00031305.2015.1089789). From about 100 units on the
difference is negligible. Bands are widened in the same way.

Quantiles come from ``scipy.special`` throughout: ``scipy.stats`` has the same ones and takes half a second to import.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from numpy.typing import ArrayLike
from scipy import special

from indoor_explorers.evaluation.statistics.estimate import CONFIDENCE
from indoor_explorers.evaluation.statistics.resampling import MapGroups


@dataclass(frozen=True)
class SmallSample:
    """Number of units and degrees of freedom of a sample."""

    units: int
    """Units that are drawn: maps where these are a sample, else episodes."""
    freedom: int
    """Degrees of freedom: units minus the groups that they are drawn within."""

    @classmethod
    def of(cls, count: int, maps: ArrayLike | None) -> SmallSample:
        """Return those of ``count`` episodes on (E,) ``maps``."""
        layout = MapGroups.of(maps, count)
        if layout.sampled:
            return cls(len(layout.size), len(layout.size) - 1)
        return cls(count, count - len(layout.size))

    @property
    def tails(self) -> tuple[float, float]:
        """The two quantiles of the resamples that bound a 95 % interval."""
        reach = self.widened(float(special.ndtri((1 + CONFIDENCE) / 2)))
        return float(special.ndtr(-reach)), float(special.ndtr(reach))

    def widened(self, multiplier: float) -> float:
        """Return how many standard deviations of the resamples correspond to ``multiplier`` for many units."""
        return math.sqrt(self.units / self.freedom) * float(-special.stdtrit(self.freedom, special.ndtr(-multiplier)))
