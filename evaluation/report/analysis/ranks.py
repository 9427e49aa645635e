"""Ranks with ties: a policy's rank is one more than the number of policies that are shown to be faster."""

from __future__ import annotations

from typing import NamedTuple

from indoor_explorers.evaluation.report.analysis.comparison import Comparison
from indoor_explorers.evaluation.report.analysis.task_times import TaskTimes
from indoor_explorers.evaluation.statistics import CONFIDENCE, FEWEST, all_pairs_test


class Rank(NamedTuple):
    """The rank of a policy on one scenario."""

    place: int
    tied: bool
    """Whether another policy has the same."""

    @property
    def text(self) -> str:
        """``2``, or ``2=`` where it is shared."""
        return f"{self.place}{'=' * self.tied}"


def ranks(comparison: Comparison) -> dict[str, Rank]:
    """Return the ranks of the ranked policies by their steps to the threshold on the tasks that all flew.

    All pairs are tested at once, see :func:`~indoor_explorers.evaluation.statistics.all_pairs_test`. Empty for a single
    policy, and where the tasks are too few for a test.
    """
    common = TaskTimes.of(comparison).common()
    if len(common.policies) < 2 or len(common.tasks) < FEWEST:
        return {}
    shown = all_pairs_test(common.times, common.maps).adjusted_p <= 1 - CONFIDENCE
    means = common.times.mean(axis=0)
    places = (1 + (shown & (means[:, None] < means)).sum(axis=0)).tolist()
    return {name: Rank(place, places.count(place) > 1) for name, place in zip(common.policies, places, strict=True)}
