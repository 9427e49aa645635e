"""Rank plot: how often a policy is better than the one ranked below it, and than the best one."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from indoor_explorers.evaluation.analysis.task_times import TaskTimes
from indoor_explorers.evaluation.drawing.dot_plots import share_dot_plot
from indoor_explorers.evaluation.drawing.formatting import EN_DASH, percent_with_interval
from indoor_explorers.evaluation.drawing.palette import PolicyStyle
from indoor_explorers.evaluation.statistics import Estimate, bootstrap_means
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
        """The probability with its interval, clipped to 0 and 100 %."""
        clipped = (None if end is None else min(max(end, 0.0), 1.0) for end in self.estimate[1:])
        return percent_with_interval(Estimate(self.estimate.mean, *clipped))

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


def improvements(task_times: TaskTimes, pairs: Sequence[tuple[str, str]]) -> dict[tuple[str, str], Improvement | None]:
    """Compare pairs of policies; those that flew the same tasks from one set of resamples."""
    paired = {names: pair for names in pairs if (pair := task_times.pair(*names)).tasks}
    found: dict[tuple[str, str], Improvement | None] = dict.fromkeys(pairs)
    for tasks in {tuple(pair.tasks) for pair in paired.values()}:
        here = {names: pair for names, pair in paired.items() if tuple(pair.tasks) == tasks}
        scores = [win_scores(pair.ours, pair.theirs) for pair in here.values()]
        estimates = bootstrap_means(np.stack(scores, axis=1), maps=next(iter(here.values())).maps)
        for names, each, estimate in zip(here, scores, estimates, strict=True):
            found[names] = Improvement(*names, estimate, each)
    return found


def rank_rows(task_times: TaskTimes) -> list[RankRow]:
    """Return a row for each policy by rank; empty when there are fewer than two with a task in common."""
    names = task_times.policies
    below, best = list(pairwise(names)), [(name, names[0]) for name in names[1:]]
    found = improvements(task_times, [*below, *best])
    if not any(found.values()):
        return []
    unders, tops = [*(found[pair] for pair in below), None], [None, *(found[pair] for pair in best)]
    return [
        RankRow(place, name, under, top, _counts(under, top))
        for place, (name, under, top) in enumerate(zip(names, unders, tops, strict=True), 1)
    ]


def _counts(*improvements: Improvement | None) -> str:
    counts = sorted({len(each.scores) for each in improvements if each is not None})
    return EN_DASH.join(str(count) for count in counts)
