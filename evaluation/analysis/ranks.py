"""Ranks with ties: a policy's rank is one more than the number of policies that are significantly better."""

from __future__ import annotations

from typing import NamedTuple

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.task_times import TaskTimes
from indoor_explorers.evaluation.statistics import FEWEST, tied_ranks


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

    See :func:`~indoor_explorers.evaluation.statistics.tied_ranks`. Empty for a single policy, and where the tasks are
    too few for a test.
    """
    common = TaskTimes.of(comparison).common()
    if len(common.policies) < 2 or len(common.tasks) < FEWEST:
        return {}
    places = tied_ranks(common.times, common.maps, reached=common.reached)
    return {name: Rank(place, places.count(place) > 1) for name, place in zip(common.policies, places, strict=True)}
