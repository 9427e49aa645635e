"""Steps of every ranked policy on every task of a scenario to its coverage threshold, as a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.coverage_threshold import CoverageThreshold


@dataclass(frozen=True, eq=False)
class PairedTimes:
    """Two policies on the tasks that both flew."""

    tasks: list[Task]
    ours: NDArray[np.float64]
    """(E,) steps; the budget where the threshold was never reached."""
    theirs: NDArray[np.float64]
    """(E,) steps."""
    maps: NDArray[np.str_]
    """(E,) which map each task was flown on; equal maps have equal labels."""


@dataclass(frozen=True, eq=False)
class TaskTimes:
    """A metric of E tasks by P policies."""

    tasks: list[Task]
    """Sorted."""
    policies: list[str]
    """Best first."""
    times: NDArray[np.float64]
    """(E, P) steps; the budget where the threshold was never reached, NaN where the task was not flown."""
    reached: NDArray[np.bool_]
    """(E, P) whether the threshold was reached."""
    maps: NDArray[np.str_]
    """(E,) which map each task was flown on; equal maps have equal labels."""
    level: CoverageThreshold
    """The coverage threshold of the scenario."""

    @classmethod
    def of(cls, comparison: Comparison, metric: str | None = None) -> TaskTimes:
        """Collect a metric of the ranked policies, by default the steps to the threshold of the scenario."""
        metric = metric or comparison.level.key
        policies = comparison.ranked_policies if comparison.groups else []
        tasks, places, maps = comparison.task_places
        times = np.full((len(tasks), len(policies)), np.nan)
        reached = np.zeros(times.shape, np.bool_)
        for column, policy in enumerate(policies):
            rows = places[policy]
            times[rows, column] = comparison.results.values(comparison.scenario, policy, metric)
            reached[rows, column] = comparison.results.measured(comparison.scenario, policy, metric)
        return cls(tasks, policies, times, reached, maps, comparison.level)

    def pair(self, policy: str, other: str) -> PairedTimes:
        """Return two policies on the tasks that both flew."""
        ours, theirs = (self.times[:, self.policies.index(name)] for name in (policy, other))
        both = ~np.isnan(ours) & ~np.isnan(theirs)
        return PairedTimes([self.tasks[row] for row in np.flatnonzero(both)], ours[both], theirs[both], self.maps[both])

    def common(self) -> TaskTimes:
        """Keep the tasks that every policy has flown."""
        return self.among(np.flatnonzero(~np.isnan(self.times).any(axis=1)).tolist())

    def among(self, rows: Sequence[int]) -> TaskTimes:
        """Keep some of the tasks."""
        tasks, kept = [self.tasks[row] for row in rows], np.array(rows, np.int64)
        return replace(self, tasks=tasks, times=self.times[kept], reached=self.reached[kept], maps=self.maps[kept])

    def by_map(self) -> dict[int, TaskTimes]:
        """Return the tasks of each map file of a scenario; generated maps count as one."""
        maps = np.array([task.map_index for task in self.tasks], np.int64)
        return {int(index): self.among(np.flatnonzero(maps == index).tolist()) for index in np.unique(maps)}
