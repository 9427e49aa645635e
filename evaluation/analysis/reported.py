"""Reported policies beside the flown ones of a scenario, compared on the tasks of both alone."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.drawing.formatting import counted
from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS, MEASURES, TIMES
from indoor_explorers.evaluation.harness.reported.rows import ReportedPolicy, ReportedRow
from indoor_explorers.evaluation.harness.results.ratios import NO_RATIO, Censoring
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import (
    Block,
    Estimate,
    PairedRatio,
    bootstrap_mean,
    paired_ratios,
    success_share,
)

#: Marks a reported policy wherever it is named.
MARK = "\N{PILCROW SIGN}"
#: Metrics that an episode which ends early has less of: what is not reached makes them bounds.
GROWING = ("path_length", "path_max", "path_max_m")
#: A map, and a seed where the rows have seeds.
TaskKey = tuple[str | None, int | None]


@dataclass(frozen=True, eq=False)
class SharedTasks:
    """A metric of a flown and a reported policy on the K tasks of both."""

    flown: NDArray[np.float64]
    """(K,) values, each the mean over the episodes of the task."""
    reported: NDArray[np.float64]
    """(K,) values."""
    reached: NDArray[np.bool_]
    """(2, K) whether the flown and the reported value are no bounds."""
    maps: NDArray[np.str_]
    """(K,) labels of the maps."""

    @property
    def censoring(self) -> Censoring:
        """In how many tasks which of the two values is a bound."""
        return Censoring.of(*self.reached)

    @property
    def ratio(self) -> PairedRatio:
        """Flown divided by reported; NaN without tasks, where values are not above 0, and where failures decide it."""
        if not len(self.flown) or (self.reported <= 0).any() or self.censoring.bound is None:
            return NO_RATIO
        return paired_ratios([Block(self.flown[:, None], self.reported[:, None], self.maps)])[0]


@dataclass(frozen=True, eq=False)
class ReportedFigures:
    """A reported policy on a scenario."""

    comparison: Comparison
    policy: ReportedPolicy

    @property
    def name(self) -> str:
        """The name with the mark."""
        return f"{self.policy.name} {MARK}"

    @cached_property
    def rows(self) -> list[ReportedRow]:
        """The rows of the scenario, without those of another number of UAVs."""
        settings = self.comparison.results.scenarios.get(self.comparison.scenario)
        teams = None if settings is None else (None, settings["team"])
        return [row for row in self.policy.on(self.comparison.scenario) if teams is None or row.team in teams]

    @cached_property
    def _maps(self) -> NDArray[np.str_]:
        """(R,) labels of the maps of the rows; where maps are generated, each seed has a map of its own."""
        settings = self.comparison.results.scenarios.get(self.comparison.scenario, {})
        generated = settings and not settings["map"].get("paths")
        return np.array([f"{row.map} {row.seed if generated else ''}" for row in self.rows], np.str_)

    @property
    def is_mean(self) -> bool:
        """Whether means alone were published."""
        return any(row.n is not None for row in self.rows)

    @property
    def count(self) -> int:
        """Number of reported episodes."""
        return sum(row.n or 1 for row in self.rows)

    @cached_property
    def metrics(self) -> list[str]:
        """The reported metrics, in the order of all metrics."""
        return [metric for metric in MEASURES if any(metric in row.metrics for row in self.rows)]

    def values(self, metric: str) -> NDArray[np.float64]:
        """Return (R,) values of the rows; NaN where missing; a time never reached counts as its budget."""
        found = [row.metrics.get(metric, math.nan) for row in self.rows]
        return np.array([row.budget if v is None else v for v, row in zip(found, self.rows, strict=True)], np.float64)

    def complete(self, metric: str) -> NDArray[np.bool_]:
        """Return (R,) whether the values of the rows are no bounds."""
        if metric in GROWING:
            return np.array([row.success != 0 for row in self.rows], np.bool_)
        return np.array([row.metrics.get(metric, math.nan) is not None for row in self.rows], np.bool_)

    def estimate(self, metric: str) -> Estimate:
        """Return the mean over all rows with its interval, maps drawn first; a published mean has none."""
        values = self.values(metric)
        held = ~np.isnan(values)
        return bootstrap_mean(values[held], maps=self._maps[held])

    @property
    def success(self) -> Estimate:
        """The share of successful episodes with its exact interval; a published share has none."""
        found = [row.success for row in self.rows if row.success is not None]
        return Estimate(found[0], None, None) if self.is_mean and found else success_share(found)

    @property
    def succeeds_at_threshold(self) -> bool:
        """Whether success means that the team reached the threshold of the scenario."""
        settings = self.comparison.results.scenarios[self.comparison.scenario]
        alone = settings["team"] == 1 or settings.get("goal_of") == "team"
        return alone and self.policy.level == self.comparison.level.share

    def flown_success(self, policy: str) -> NDArray[np.bool_] | None:
        """Return (E,) whether a flown policy succeeded in the sense of the rows; None where that was not measured."""
        results, scenario = self.comparison.results, self.comparison.scenario
        if self.policy.level == float(results.scenarios[scenario].get("goal", 1.0)):
            return results.reached(scenario, policy, "auc")
        key = next((key for key, share in LEVELS.items() if share == self.policy.level), None)
        return results.reached(scenario, policy, key) if key and results.applies_to(scenario, key) else None

    # -- tasks of both ------------------------------------------------------------------------------------

    @cached_property
    def _places(self) -> dict[TaskKey, list[int]]:
        found: dict[TaskKey, list[int]] = {}
        for place, row in enumerate(self.rows):
            found.setdefault((row.map, row.seed), []).append(place)
        return found

    @cached_property
    def shared(self) -> Callable[[str], dict[TaskKey, list[int]]]:
        """Function of a flown policy: the places of its episodes by the tasks that the rows have too.

        These are of the same map, start and team. Rows without a seed are of the start that the map marks, and have no
        task on maps that mark none; nor has a name that several maps have.
        """
        return cache(self._shared)

    def _shared(self, policy: str) -> dict[TaskKey, list[int]]:
        listed = not isinstance(self.comparison.results.scenarios[self.comparison.scenario]["spawn"], str)
        records = self.comparison.groups[policy]
        found: dict[TaskKey, list[int]] = {}
        for place, record in enumerate(records):
            key: TaskKey = (record.floorplan.name, record.task.seed)
            if key not in self._places and (listed or record.floorplan.start is not None):
                key = (record.floorplan.name, None)
            if key in self._places:
                found.setdefault(key, []).append(place)
        alike = {key: {records[place].floorplan.digest for place in places} for key, places in found.items()}
        return {key: places for key, places in found.items() if len(alike[key]) == 1}

    def pairs(self, policy: str, metric: str) -> SharedTasks:
        """Return a metric of a flown policy and the rows on the tasks of both."""
        results, scenario = self.comparison.results, self.comparison.scenario
        shared, ours, theirs = self.shared(policy), results.values(scenario, policy, metric), self.values(metric)
        complete = self._flown_complete(policy, metric), self.complete(metric)
        labels = self.comparison.maps(policy)
        columns = [(places, self._places[key]) for key, places in shared.items()]
        flown = np.array([ours[one].mean() for one, _ in columns], np.float64)
        reported = np.array([theirs[other].mean() for _, other in columns], np.float64)
        reached = [[part[places].all() for part, places in zip(complete, pair, strict=True)] for pair in columns]
        held = ~np.isnan(flown) & ~np.isnan(reported)
        if metric in LEVELS:  # a threshold reached at the start counts as one step
            flown, reported = np.maximum(flown, 1.0), np.maximum(reported, 1.0)
        return SharedTasks(
            *(flown[held], reported[held], np.array(reached, np.bool_).reshape(-1, 2)[held].T),
            np.array([labels[places[0]] for places, _ in columns], np.str_)[held],
        )

    def _flown_complete(self, policy: str, metric: str) -> NDArray[np.bool_]:
        if metric in TIMES:
            return self.comparison.results.measured(self.comparison.scenario, policy, metric)
        success = self.flown_success(policy) if metric in GROWING else None
        return np.ones(len(self.comparison.groups[policy]), np.bool_) if success is None else success

    @cached_property
    def tasks(self) -> int:
        """How many tasks the rows share with the flown policies, the most of any."""
        return max((len(self.shared(policy)) for policy in self.comparison.groups), default=0)

    @property
    def note(self) -> str:
        """The sentence that says where the figures come from, and over what they are compared."""
        source = self.policy.source
        cited = f"{source.citation} ({source.url})"
        start = f"{self.name} reported by {cited}, not flown here: "
        if source.measured:
            start = f"{self.name} measured here in {cited}, not flown in this world: "
        if self.is_mean:
            over = counted(self.count, "episode")
            return f"{start}published means over {over}, without rows: no interval and no comparison by task."
        maps, late = len(np.unique(self._maps)), sum(None in row.metrics.values() for row in self.rows)
        other = len(self.policy.on(self.comparison.scenario)) - len(self.rows)
        shared = f"{counted(self.tasks, 'task')} shared with flown policies" if self.comparison.groups else ""
        parts = [
            f"{counted(len(self.rows), 'row')} on {counted(maps, 'map')}",
            f"{shared}, compared there alone" if self.tasks else shared,
            f"times never reached, in {counted(late, 'row')}, count as the budget" if late else "",
            f"left out: {counted(other, 'row')} of another number of UAVs" if other else "",
        ]
        return f"{start}{'; '.join(filter(None, parts))}."


def reported_on(comparison: Comparison) -> list[ReportedFigures]:
    """Return the reported policies of a scenario."""
    found = [ReportedFigures(comparison, policy) for policy in comparison.results.reported]
    return [each for each in found if each.policy.on(comparison.scenario)]


def all_reported(results: Results) -> list[ReportedFigures]:
    """Return all reported policies: on the scenarios in their order, then on those that were not flown."""
    names = dict.fromkeys([*results.scenarios, *(name for policy in results.reported for name in policy.scenarios)])
    comparisons = (Comparison(results.on_common_tasks, name) for name in (names if results.reported else ()))
    return [figures for comparison in comparisons for figures in reported_on(comparison)]
