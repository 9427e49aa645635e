"""Rank plot: how often a policy is better than the one ranked below it, and than the best one."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from indoor_explorers.evaluation.report.analysis.task_times import TaskTimes
from indoor_explorers.evaluation.report.charts.dot_plots import share_dot_plot
from indoor_explorers.evaluation.report.style.formatting import EN_DASH, percent
from indoor_explorers.evaluation.report.style.palette import PolicyStyle
from indoor_explorers.evaluation.statistics import Estimate, probability_of_improvement
from indoor_explorers.evaluation.statistics.wins import win_scores


class Improvement(NamedTuple):
    """The probability that one policy does better than another on a task."""

    policy: str
    other: str
    estimate: Estimate
    scores: NDArray[np.float64]
    """(E,) 1 where better, 0.5 where equal, 0 where worse."""

    @property
    def text(self) -> str:
        """The probability with its interval."""
        _, low, high = self.estimate
        around = "" if low is None or high is None else f" [{_clipped(low)}, {_clipped(high)}]"
        return percent(self.estimate.mean) + around

    @property
    def reading(self) -> str:
        """What the interval says about which of the two is better on most tasks.

        Where the tasks of each map all have the same result the interval has no width, and no claim is made.
        """
        mean, low, high = self.estimate
        if low is None or high is None:
            return "too few tasks"
        if (self.scores == 0.5).all():
            return "equal on every task"
        if mean in (0.0, 1.0):
            return "on every task" if mean else "on no task"
        if high - low < 1e-9:
            return "no spread to judge by"
        return "better on most" if low > 0.5 else "worse on most" if high < 0.5 else "not decided"

    def dot_plot(self, style: PolicyStyle) -> Markup:
        """Draw it with a line at one half; without an interval, a dot for each task."""
        label = f"{self.policy} better than {self.other}: {self.text}"
        return share_dot_plot(self.scores, self.estimate, style, label)


def _clipped(share: float) -> str:
    """Format the end of an interval, clipped to 0 and 100 %."""
    return percent(min(max(share, 0.0), 1.0))


class RankRow(NamedTuple):
    """One policy of the rank plot, best first."""

    place: int
    policy: str
    next: Improvement | None
    """Against the policy ranked next; None for the last."""
    best: Improvement | None
    """Against the best; None for the best itself."""
    tasks: str
    """Number of common tasks with the next, and with the best."""


def improvement(task_times: TaskTimes, policy: str, other: str) -> Improvement | None:
    """Compare two policies on the tasks that both flew; None without any."""
    pair = task_times.pair(policy, other)
    if not pair.tasks:
        return None
    scores = win_scores(pair.ours, pair.theirs)
    return Improvement(policy, other, probability_of_improvement(pair.ours, pair.theirs, maps=pair.maps), scores)


def rank_rows(task_times: TaskTimes) -> list[RankRow]:
    """Return a row for each policy by rank; empty when there are fewer than two with a task in common."""
    names = task_times.policies
    below = [improvement(task_times, one, other) for one, other in pairwise(names)] + [None]
    best = [None] + [improvement(task_times, name, names[0]) for name in names[1:]]
    if not any([*below, *best]):
        return []
    return [
        RankRow(place, name, under, top, _counts(under, top))
        for place, (name, under, top) in enumerate(zip(names, below, best, strict=True), 1)
    ]


def _counts(*improvements: Improvement | None) -> str:
    counts = sorted({len(each.scores) for each in improvements if each is not None})
    return EN_DASH.join(str(count) for count in counts)
