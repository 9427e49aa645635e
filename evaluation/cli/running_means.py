"""Running means of the policies of a comparison, each over the tasks that all of them have flown."""

from __future__ import annotations

from typing import NamedTuple

from indoor_explorers.evaluation.harness.episodes.record import FlownEpisode, Outcome
from indoor_explorers.evaluation.harness.experiment.experiment import Task


class Figures(NamedTuple):
    """The figures of an episode, or their sums."""

    auc: float = 0.0
    coverage: float = 0.0
    """Of the team at the end, from 0 to 1."""
    reached: float = 0.0
    """1 where the team reached the coverage threshold of the scenario, else 0."""

    def plus(self, other: Figures) -> Figures:
        """Return the sums."""
        return Figures(*(mine + theirs for mine, theirs in zip(self, other, strict=True)))

    def over(self, count: int) -> Figures:
        """Return the means over this many episodes."""
        return Figures(*(value / count for value in self))


class RunningMeans:
    """Means of the policies while they fly, over the tasks that every policy seen so far has flown.

    Means over all flown episodes would favour a policy that happens to fly an easier scenario first.
    """

    def __init__(self) -> None:
        self.tasks = 0
        """How many tasks the means are over."""
        self.episodes: dict[str, int] = {}
        """Episodes flown by policy, in this run."""
        self.failed: dict[str, int] = {}
        """Those of them that failed."""
        self._flown: dict[str, dict[Task, Figures]] = {}
        self._sums: dict[str, Figures] = {}

    def add(self, record: FlownEpisode, reached: bool) -> None:
        """Add an episode; ``reached`` says whether the team reached the coverage threshold of its scenario."""
        name = record.policy
        if name not in self._flown:  # a new policy: no task is common to all any more
            self._flown[name], self.episodes[name], self.failed[name] = {}, 0, 0
            self.tasks, self._sums = 0, dict.fromkeys(self._flown, Figures())
        self.episodes[name] += 1
        self.failed[name] += record.outcome is Outcome.FAILED
        auc = record.metrics.get("auc") or 0.0
        self._flown[name][record.task] = Figures(auc, float(record.curve[-1]), float(reached))
        if all(record.task in flown for flown in self._flown.values()):
            self.tasks += 1
            self._sums = {each: self._sums[each].plus(flown[record.task]) for each, flown in self._flown.items()}

    def means(self) -> dict[str, Figures | None]:
        """Return the means of each policy, None while there is no common task."""
        return {name: sums.over(self.tasks) if self.tasks else None for name, sums in self._sums.items()}
