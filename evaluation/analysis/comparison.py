"""The comparison of the policies on one scenario: ranking, estimates and contrasts."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.drawing.formatting import counted
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.coverage_threshold import CoverageThreshold
from indoor_explorers.evaluation.harness.results.map_labels import unit_of
from indoor_explorers.evaluation.harness.results.ratios import Censoring
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import (
    CONFIDENCE,
    FEWEST,
    Contrast,
    Estimate,
    bootstrap_mean,
    contrasts,
    maps_are_sampled,
    undetected_share,
)
from indoor_explorers.evaluation.statistics.resampling import independent_units


@dataclass(frozen=True, eq=False)
class Comparison:
    """The policies of one scenario compared with each other."""

    results: Results
    scenario: str

    @property
    def title(self) -> str:
        """What the scenario is called in titles and captions."""
        return self.results.title(self.scenario)

    @cached_property
    def groups(self) -> dict[str, list[Record]]:
        """The records by policy, without policies that have none."""
        groups = self.results.groups.items()
        return {policy: records for (scenario, policy), records in groups if scenario == self.scenario}

    @cached_property
    def records(self) -> list[Record]:
        """The records of all policies, policy by policy."""
        return [record for group in self.groups.values() for record in group]

    @cached_property
    def level(self) -> CoverageThreshold:
        """The coverage threshold of the scenario."""
        return self.results.level(self.scenario)

    def maps(self, policy: str) -> NDArray[np.str_]:
        """Return (E,) the map, building or layout of each episode of a policy (:meth:`Results.maps`)."""
        return self.results.maps(self.scenario, policy)

    @cached_property
    def map_count(self) -> int:
        """How many different maps were flown."""
        return len({record.floorplan.digest for record in self.records})

    @cached_property
    def _units(self) -> set[str]:
        return {label for policy in self.groups for label in self.maps(policy).tolist()}

    @property
    def unit_count(self) -> int:
        """How many they are where maps of one building or layout count as one."""
        return len(self._units)

    @property
    def maps_flown(self) -> str:
        """``8 maps``, or ``8 maps of 3 buildings`` where some count as one."""
        maps = counted(self.map_count, "map")
        several = self.unit_count < self.map_count
        return f"{maps} of {counted(self.unit_count, unit_of(self._units))}" if several else maps

    @cached_property
    def over_maps(self) -> bool:
        """Whether intervals hold for maps like these; False: for these maps alone, which are few."""
        return all(maps_are_sampled(self.maps(policy)) for policy in self.groups)

    def privileged(self, policy: str) -> bool:
        """Return whether the policy is given the true map."""
        return bool(self.results.policies[policy].get("privileged", False))

    def ranked(self, policy: str) -> bool:
        """Return whether the policy is ranked: it is not given the true map and failed no check of what it knows."""
        return not self.privileged(policy) and policy not in self.results.failed_checks

    def estimate(self, policy: str, metric: str) -> Estimate:
        """Return the mean of a metric with its interval; NaN where it was not measured or is above the goal."""
        missing = Estimate(float("nan"), None, None)
        if not self.results.applies_to(self.scenario, metric):
            return missing
        return self.results.estimates(self.scenario, policy).get(metric, missing)

    def time(self, policy: str) -> Estimate:
        """Return the mean steps to the threshold; an episode that never reached it counts as its budget."""
        return self.estimate(policy, self.level.key)

    def success(self, policy: str) -> Estimate:
        """Return the share of a policy's episodes that reached the threshold, with its interval."""
        return self.results.success(self.scenario, policy, self.level.key)

    def reached(self, policy: str) -> float:
        """Return the share of a policy's episodes that reached the threshold."""
        return self.success(policy).mean

    def to_reference(self, policy: str) -> Estimate:
        """Return the mean ratio of a policy's steps to the reference's steps; NaN without a reference."""
        ratios = self.results.to_reference(self.scenario, policy, self.level.key)
        held = ~np.isnan(ratios)
        return bootstrap_mean(ratios[held], maps=self.maps(policy)[held])

    def reference_censoring(self, policy: str) -> Censoring:
        """Count the tasks on which a policy or the reference never reached the threshold."""
        known = self.results.references.get(self.scenario, {})
        pairs = [
            (record, known[record.task]) for record in (self.groups[policy] if known else ()) if record.task in known
        ]
        reached = [[record.metrics.get(self.level.key) is not None for record in pair] for pair in pairs]
        return Censoring.of(*np.array(reached, np.bool_).reshape(-1, 2).T)

    @property
    def tallies(self) -> list[str]:
        """The names of the pilot statistics, such as ``pilot_guarded``."""
        names = {name for policy in self.groups for name in self.results.metric_names(self.scenario, policy)}
        return sorted(name for name in names if name.startswith("pilot_"))

    @cached_property
    def ranking(self) -> list[str]:
        """All policies by mean time to the threshold, then falling AUC; those that are not ranked come last."""
        return sorted(self.groups, key=lambda policy: (not self.ranked(policy), *self._rank(policy)))

    def _rank(self, policy: str) -> tuple[float, float]:
        late = float(self._times(policy).mean())
        area = float(self.results.values(self.scenario, policy, "auc").mean())
        return late, -area if area == area else 0.0

    @cached_property
    def ranked_policies(self) -> list[str]:
        """The policies that are :meth:`ranked`, best first; all policies when none is."""
        return [policy for policy in self.ranking if self.ranked(policy)] or self.ranking

    @cached_property
    def task_places(self) -> tuple[list[Task], dict[str, list[int]], NDArray[np.str_]]:
        """The tasks of the ranked policies in order, the place of each episode's by policy, and (E,) their maps."""
        groups = {policy: self.groups[policy] for policy in (self.ranked_policies if self.groups else [])}
        tasks = sorted({record.task for records in groups.values() for record in records})
        place = {task: row for row, task in enumerate(tasks)}
        places = {policy: [place[record.task] for record in records] for policy, records in groups.items()}
        labels: dict[int, str] = {}
        for policy, rows in places.items():
            labels |= dict(zip(rows, self.maps(policy).tolist(), strict=True))
        return tasks, places, np.array([labels[row] for row in range(len(tasks))], np.str_)

    @cached_property
    def aligned(self) -> bool:
        """Whether all policies flew the same tasks, so that their episodes can be paired."""
        tasks = [[record.task for record in records] for records in self.groups.values()]
        return all(each == tasks[0] for each in tasks)

    @property
    def contrasts(self) -> dict[str, Contrast]:
        """Steps and successes of the others against the best-ranked, see :attr:`contrasts_with`."""
        return self.contrasts_with(self.ranked_policies[0]) if self.groups else {}

    @cached_property
    def contrasts_with(self) -> Callable[[str], dict[str, Contrast]]:
        """Function of a ranked policy: steps and successes of the others against it; empty where tasks differ.

        All pairs of ranked policies are tested at once, since any could have been chosen to be the first. The others
        are a family of their own, so that they do not change the p-values of the ranked.
        """
        return cache(self._contrasts_with)

    def _contrasts_with(self, first: str) -> dict[str, Contrast]:
        if not self.groups or not self.aligned:
            return {}
        ranked = [first, *(policy for policy in self.ranked_policies if policy != first)]
        others = [policy for policy in self.ranking if policy not in ranked]
        return self._family(ranked, chosen=True) | self._family([first, *others])

    @cached_property
    def success_p_values(self) -> dict[str, float]:
        """The p-value of every ranked policy's success against that of the best-ranked, adjusted for all pairs."""
        found = self.contrasts
        return {name: found[name].success_p for name in found if name in self.ranked_policies}

    def success_differs(self, policy: str) -> bool:
        """Return whether a policy is shown to reach the threshold more or less often than the best-ranked."""
        few = len(self.groups[policy]) < FEWEST
        return not few and self.success_p_values.get(policy, 1.0) <= 1 - CONFIDENCE

    def _reached(self, policy: str) -> NDArray[np.bool_]:
        """Return (E,) whether each episode reached the threshold of the scenario."""
        return self.results.reached(self.scenario, policy, self.level.key)

    def _family(self, policies: Sequence[str], *, chosen: bool = False) -> dict[str, Contrast]:
        return contrasts(
            {policy: self._times(policy) for policy in policies},
            policies[0],
            maps=self.maps(policies[0]),
            chosen=chosen,
            reached={policy: self._reached(policy) for policy in policies},
            margin=self.results.margin,
        )

    @cached_property
    def twins(self) -> list[list[str]]:
        """The policies that flew the same episodes, action for action, in groups of two or more."""
        groups: dict[str, list[str]] = {}
        for policy, records in self.groups.items():
            groups.setdefault(_flights(records, self.level.key), []).append(policy)
        return [names for names in groups.values() if len(names) > 1]

    @property
    def same_as(self) -> dict[str, str]:
        """The policies that flew the same episodes as one listed before them, each with that one."""
        return {name: names[0] for names in self.twins for name in names[1:]}

    def differences(self, policy: str) -> NDArray[np.float64]:
        """Return (B,) steps minus the best-ranked policy's on the B tasks that both finished; needs :attr:`aligned`."""
        first = self.ranked_policies[0]
        both = self._reached(policy) & self._reached(first)
        return np.asarray(self._times(policy) - self._times(first))[both]

    def undetected(self, policy: str) -> tuple[float, float] | None:
        """Return the share of failures that a policy's episodes cannot exclude, and how many steps these would cost.

        The steps would be added to its mean. Where maps are a sample, they are counted instead of episodes. None where
        it finished no task.
        """
        reached, times = self._reached(policy), self._times(policy)
        if not reached.any():
            return None
        failed = independent_units((~reached).astype(np.float64), self.maps(policy)) > 0
        share = undetected_share(int(failed.sum()), len(failed))
        budget = float(np.mean([record.budget for record in self.groups[policy]]))
        return share, max(0.0, share - float((~reached).mean())) * (budget - float(times[reached].mean()))

    def _times(self, policy: str) -> NDArray[np.float64]:
        """Return (E,) steps to the threshold of the scenario."""
        return self.results.values(self.scenario, policy, self.level.key)


def _flights(records: Sequence[Record], metric: str) -> str:
    """Return a digest of tasks, times, actions and coverage."""
    digest = hashlib.sha256()
    for record in records:
        digest.update(repr((record.task, record.metrics.get(metric))).encode())
        digest.update(record.facts.flight)
    return digest.hexdigest()
