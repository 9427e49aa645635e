"""The coverage level that a scenario is judged by: the highest of T50, T90, T95 and T99 that its goal asks for.

An episode ends at the goal, so that nobody has a time for a level above it: those times would all be the budget.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from indoor_explorers.evaluation.episodes.metrics import LEVELS, MEASURES

#: Levels that a scenario may be judged by, the highest first; the last one is for all lower goals too.
JUDGING = ("t99", "t95", "t90", "t50")


@dataclass(frozen=True)
class CoverageThreshold:
    """A coverage level by the key of the metric that is its time."""

    key: str
    """One of :data:`~indoor_explorers.evaluation.episodes.metrics.LEVELS`."""

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
        """The metrics to draw where a scenario is judged by this level: T90 and its own, never one above."""
        return ("t90", self.key) if self.share > LEVELS["t90"] else (self.key,)


#: What most scenarios are judged by.
T99 = CoverageThreshold("t99")


def threshold_of(goal: float) -> CoverageThreshold:
    """Return the level that a scenario with this goal coverage is judged by."""
    return CoverageThreshold(next((key for key in JUDGING if applies_to(goal, key)), JUDGING[-1]))


def applies_to(goal: float, metric: str) -> bool:
    """Return whether a goal coverage asks for a metric: a time, or what is made of one, up to the goal; all others."""
    return LEVELS.get(metric.partition("_")[0], 0.0) <= max(goal, LEVELS[JUDGING[-1]])


def shared(levels: Iterable[CoverageThreshold]) -> CoverageThreshold | None:
    """Return the one level that all are; None where they differ or there is none."""
    different = set(levels)
    return different.pop() if len(different) == 1 else None


def tabled(levels: Iterable[CoverageThreshold]) -> tuple[str, ...]:
    """Return the times that a table of scenarios judged by these levels has a column for, by rising coverage."""
    return tuple(sorted({"t90", "t99", *(level.key for level in levels)}, key=LEVELS.__getitem__))


def drawn(levels: Iterable[CoverageThreshold]) -> tuple[str, ...]:
    """Return the :attr:`~CoverageThreshold.times` of all these levels, by rising coverage."""
    return tuple(sorted({key for level in levels for key in level.times}, key=LEVELS.__getitem__))
