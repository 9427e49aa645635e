"""Who was first, and by how much: rankings and paired differences of one scenario."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.experiment import Task
from indoor_explorers.evaluation.record import Record
from indoor_explorers.evaluation.results import Results
from indoor_explorers.evaluation.statistics import Estimate, bootstrap_mean, maps_are_sampled, paired_difference


@dataclass(frozen=True, eq=False)
class Paired:
    """Compare a policy with a baseline over the tasks that both flew."""

    policy: str
    baseline: str
    differences: NDArray[np.float64]
    """(E,) policy minus baseline, in steps."""

    @cached_property
    def estimate(self) -> Estimate:
        """The mean difference with its interval."""
        return paired_difference(self.differences, np.zeros_like(self.differences))

    @property
    def shown(self) -> bool:
        """True when there is an interval and it leaves out 0."""
        low, high = self.estimate.low, self.estimate.high
        return low is not None and high is not None and (low > 0 or high < 0)

    @property
    def tally(self) -> tuple[int, int, int]:
        """In how many episodes the policy needed fewer, as many and more steps than the baseline."""
        signs = np.sign(self.differences)
        return int((signs < 0).sum()), int((signs == 0).sum()), int((signs > 0).sum())


@dataclass(frozen=True, eq=False)
class Comparison:
    """The policies of one scenario against each other."""

    results: Results
    scenario: str

    @cached_property
    def groups(self) -> dict[str, list[Record]]:
        """The records by policy, policies without any left out."""
        groups = self.results.groups.items()
        return {policy: records for (scenario, policy), records in groups if scenario == self.scenario}

    def maps(self, policy: str) -> NDArray[np.str_]:
        """Return (E,) which map each episode of a policy was flown on; equal maps have equal labels."""
        return self.results.maps(self.scenario, policy)

    @cached_property
    def map_count(self) -> int:
        """How many different maps were flown."""
        return len({label for policy in self.groups for label in self.maps(policy).tolist()})

    @cached_property
    def over_maps(self) -> bool:
        """Whether intervals speak about maps like these; False: about these maps alone, which are few."""
        return all(maps_are_sampled(self.maps(policy)) for policy in self.groups)

    def privileged(self, policy: str) -> bool:
        """Return whether the policy is given the true map."""
        return bool(self.results.policies[policy].get("privileged", False))

    def estimate(self, policy: str, metric: str) -> Estimate:
        """Return the mean of a metric with its interval; a NaN mean where nothing was measured."""
        if (policy, metric) not in self._estimates:
            values = self.results.values(self.scenario, policy, metric)
            held = ~np.isnan(values)
            self._estimates[policy, metric] = bootstrap_mean(values[held], maps=self.maps(policy)[held])
        return self._estimates[policy, metric]

    @cached_property
    def _estimates(self) -> dict[tuple[str, str], Estimate]:
        return {}

    @property
    def tallies(self) -> list[str]:
        """The names of what the pilots tallied, such as ``pilot_guarded``."""
        names = {name for records in self.groups.values() for record in records for name in record.metrics}
        return sorted(name for name in names if name.startswith("pilot_"))

    @cached_property
    def ranking(self) -> list[str]:
        """All policies by mean T99, then by falling AUC, then as listed; those that know the map come last."""
        return sorted(self.groups, key=lambda policy: (self.privileged(policy), *self._rank(policy)))

    def _rank(self, policy: str) -> tuple[float, float]:
        late = float(self.results.values(self.scenario, policy, "t99").mean())
        area = float(self.results.values(self.scenario, policy, "auc").mean())
        return late, -area if area == area else 0.0

    @cached_property
    def contestants(self) -> list[str]:
        """The ranked policies that do not know the map; all of them when every one does."""
        return [policy for policy in self.ranking if not self.privileged(policy)] or self.ranking

    def paired(self, policy: str, baseline: str, metric: str = "t99") -> Paired:
        """Return the differences of a metric over the tasks that both flew."""
        ours, theirs = self._by_task(policy, metric), self._by_task(baseline, metric)
        common = sorted(ours.keys() & theirs.keys())
        return Paired(policy, baseline, np.array([ours[task] - theirs[task] for task in common], np.float64))

    def _by_task(self, policy: str, metric: str) -> Mapping[Task, float]:
        values = self.results.values(self.scenario, policy, metric).tolist()
        return {record.task: value for record, value in zip(self.groups[policy], values, strict=True)}
