"""T99 of every contestant on every task of a scenario, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.experiment import Task
from indoor_explorers.evaluation.report.comparison import Comparison


@dataclass(frozen=True, eq=False)
class Pair:
    """Two policies on the tasks that both flew."""

    tasks: list[Task]
    ours: NDArray[np.float64]
    """(E,) steps; the budget where the level was never reached."""
    theirs: NDArray[np.float64]
    """(E,) steps."""

    @property
    def maps(self) -> list[int]:
        """(E,) the map of each task."""
        return [task.map_index for task in self.tasks]


@dataclass(frozen=True, eq=False)
class Outcomes:
    """A metric of E tasks by P policies."""

    tasks: list[Task]
    """Sorted."""
    policies: list[str]
    """Best first."""
    times: NDArray[np.float64]
    """(E, P) steps, the budget where the level was never reached, NaN where the policy has not flown the task."""
    reached: NDArray[np.bool_]
    """(E, P) whether the level was reached."""

    @classmethod
    def of(cls, comparison: Comparison, metric: str = "t99") -> Outcomes:
        """Collect a scenario's policies, without those that know the map unless all do."""
        policies = comparison.contestants if comparison.groups else []
        tasks = sorted({record.task for policy in policies for record in comparison.groups[policy]})
        place = {task: row for row, task in enumerate(tasks)}
        times = np.full((len(tasks), len(policies)), np.nan)
        reached = np.zeros(times.shape, np.bool_)
        for column, policy in enumerate(policies):
            records = comparison.groups[policy]
            rows = [place[record.task] for record in records]
            times[rows, column] = comparison.results.values(comparison.scenario, policy, metric)
            reached[rows, column] = [record.metrics.get(metric) is not None for record in records]
        return cls(tasks, policies, times, reached)

    def pair(self, policy: str, other: str) -> Pair:
        """Return two policies on the tasks that both flew."""
        ours, theirs = (self.times[:, self.policies.index(name)] for name in (policy, other))
        both = ~np.isnan(ours) & ~np.isnan(theirs)
        return Pair([self.tasks[row] for row in np.flatnonzero(both)], ours[both], theirs[both])

    def common(self) -> Outcomes:
        """Keep the tasks that every policy has flown."""
        return self.among(np.flatnonzero(~np.isnan(self.times).any(axis=1)).tolist())

    def among(self, rows: Sequence[int]) -> Outcomes:
        """Keep some of the tasks."""
        return Outcomes([self.tasks[row] for row in rows], self.policies, self.times[rows], self.reached[rows])

    def by_map(self) -> dict[int, Outcomes]:
        """Return the tasks of each map."""
        maps = np.array([task.map_index for task in self.tasks], np.int64)
        return {int(index): self.among(np.flatnonzero(maps == index).tolist()) for index in np.unique(maps)}
