"""The coverage threshold of a scenario: the highest of 50, 90, 95 and 99 % that is not above its goal.

Policies are compared by their steps to it. An episode ends at the goal, so that no policy has a time for a threshold
above it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS, MEASURES

#: Possible thresholds of a scenario, the highest first; the last one is used for all lower goals too.
JUDGING = ("t99", "t95", "t90", "t50")


@dataclass(frozen=True)
class CoverageThreshold:
    """A coverage threshold, named by the metric of its time."""

    key: str
    """One of :data:`~indoor_explorers.evaluation.harness.episodes.metrics.LEVELS`."""

    @property
    def share(self) -> float:
        """The coverage, from 0 to 1."""
        return LEVELS[self.key]

    @property
    def percent(self) -> str:
        """The coverage in words: ``90 %``."""
        return f"{100 * self.share:.0f} %"

    @property
    def title(self) -> str:
        """The name of its time: ``T90``."""
        return MEASURES[self.key].title

    @property
    def times(self) -> tuple[str, ...]:
        """The times to show for a scenario with this threshold: T90 and its own, never one above it."""
        return ("t90", self.key) if self.share > LEVELS["t90"] else (self.key,)


#: The threshold of most scenarios.
T99 = CoverageThreshold("t99")


def threshold_of(goal: float) -> CoverageThreshold:
    """Return the threshold of a scenario with this goal coverage."""
    return CoverageThreshold(next((key for key in JUDGING if applies_to(goal, key)), JUDGING[-1]))


def applies_to(goal: float, metric: str) -> bool:
    """Return whether a metric can be measured at a goal coverage: times up to the goal can, and all other metrics."""
    return LEVELS.get(metric.partition("_")[0], 0.0) <= max(goal, LEVELS[JUDGING[-1]])


def shared(levels: Iterable[CoverageThreshold]) -> CoverageThreshold | None:
    """Return the threshold that all of these are; None where they differ or there is none."""
    different = set(levels)
    return different.pop() if len(different) == 1 else None


def tabled(levels: Iterable[CoverageThreshold]) -> tuple[str, ...]:
    """Return the times that a table of scenarios with these thresholds has a column for, by rising coverage."""
    return tuple(sorted({"t90", "t99", *(level.key for level in levels)}, key=LEVELS.__getitem__))


def drawn(levels: Iterable[CoverageThreshold]) -> tuple[str, ...]:
    """Return the :attr:`~CoverageThreshold.times` of all these thresholds, by rising coverage."""
    return tuple(sorted({key for level in levels for key in level.times}, key=LEVELS.__getitem__))
