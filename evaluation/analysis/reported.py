"""Reported policies beside the flown ones of a scenario, compared on the tasks of both alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.drawing.formatting import counted, percent
from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS, MEASURES, OTHER_TIMES
from indoor_explorers.evaluation.harness.reported.rows import ReportedEpisode, ReportedMean, ReportedPolicy
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
NO_ESTIMATE = Estimate(float("nan"), None, None)
#: A map, and a seed where the rows have seeds.
TaskKey = tuple[str, int | None]


def marked_name(policy: ReportedPolicy) -> str:
    """Return the name of a reported policy with its mark."""
    return f"{policy.name} {MARK}"


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
        return marked_name(self.policy)

    @cached_property
    def _all(self) -> tuple[list[ReportedEpisode], list[ReportedMean]]:
        name = self.comparison.scenario
        return (
            [each for each in self.policy.episodes if each.scenario == name],
            [each for each in self.policy.means if each.scenario == name],
        )

    def _is_of_team(self, row: ReportedEpisode | ReportedMean) -> bool:
        settings = self.comparison.results.scenarios.get(self.comparison.scenario)
        return settings is None or row.team in (None, settings["team"])

    @cached_property
    def episodes(self) -> list[ReportedEpisode]:
        """The rows of the scenario, without those of another number of UAVs."""
        return list(filter(self._is_of_team, self._all[0]))

    @cached_property
    def mean(self) -> ReportedMean | None:
        """The published means of the scenario where there are no rows."""
        return None if self.episodes else next(filter(self._is_of_team, self._all[1]), None)

    @property
    def left_out(self) -> int:
        """How many rows are of another number of UAVs."""
        return sum(not self._is_of_team(each) for part in self._all for each in part)

    @property
    def count(self) -> int:
        """Number of reported episodes."""
        return self.mean.episodes if self.mean else len(self.episodes)

    @cached_property
    def metrics(self) -> list[str]:
        """The reported metrics, in the order of all metrics."""
        rows = [self.mean] if self.mean else self.episodes
        held = {metric for row in rows for metric in row.metrics}
        return [metric for metric in MEASURES if metric in held]

    def values(self, metric: str) -> NDArray[np.float64]:
        """Return (R,) values of the rows; NaN where missing; a time never reached counts as its budget."""
        missing = {True: math.nan, False: None}
        found = [each.metrics.get(metric, missing[metric not in each.metrics]) for each in self.episodes]
        budgets = [each.budget for each in self.episodes]
        return np.array([b if v is None else v for v, b in zip(found, budgets, strict=True)], np.float64)

    def complete(self, metric: str) -> NDArray[np.bool_]:
        """Return (R,) whether the values of the rows are no bounds."""
        if metric in GROWING:
            return np.array([each.success is not False for each in self.episodes], np.bool_)
        if metric in LEVELS or metric in OTHER_TIMES:
            return np.array([each.metrics.get(metric) is not None for each in self.episodes], np.bool_)
        return np.ones(len(self.episodes), np.bool_)

    def estimate(self, metric: str) -> Estimate:
        """Return the mean over all rows with its interval, maps drawn first; a published mean has none."""
        if self.mean:
            value = self.mean.metrics.get(metric)
            return NO_ESTIMATE if value is None else Estimate(value, None, None)
        values = self.values(metric)
        held = ~np.isnan(values)
        return bootstrap_mean(values[held], maps=np.array([each.map for each in self.episodes])[held])

    @property
    def success(self) -> Estimate:
        """The share of successful episodes with its exact interval; a published share has none."""
        if self.mean:
            return NO_ESTIMATE if self.mean.success is None else Estimate(self.mean.success, None, None)
        return success_share([each.success for each in self.episodes if each.success is not None])

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
    def _rows(self) -> dict[TaskKey, list[int]]:
        found: dict[TaskKey, list[int]] = {}
        for place, each in enumerate(self.episodes):
            found.setdefault((each.map, each.seed), []).append(place)
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
            if key not in self._rows and (listed or record.floorplan.start is not None):
                key = (record.floorplan.name, None)
            if key in self._rows:
                found.setdefault(key, []).append(place)
        alike = {key: {records[place].floorplan.digest for place in places} for key, places in found.items()}
        return {key: places for key, places in found.items() if len(alike[key]) == 1}

    def pairs(self, policy: str, metric: str) -> SharedTasks:
        """Return a metric of a flown policy and the rows on the tasks of both."""
        results, scenario = self.comparison.results, self.comparison.scenario
        shared, ours, theirs = self.shared(policy), results.values(scenario, policy, metric), self.values(metric)
        complete = self._flown_complete(policy, metric), self.complete(metric)
        labels = self.comparison.maps(policy)
        columns = [(places, self._rows[key]) for key, places in sorted(shared.items(), key=lambda each: str(each[0]))]
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
        if metric in LEVELS or metric in OTHER_TIMES:
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
        start = f"{self.name} reported by {source.citation} ({source.url}), not flown here: "
        if self.mean:
            over = counted(self.mean.episodes, "episode")
            return f"{start}published means over {over}, without rows: no interval and no comparison by task."
        maps = len({each.map for each in self.episodes})
        text = f"{start}{counted(len(self.episodes), 'row')} on {counted(maps, 'map')}"
        if self.comparison.groups:
            both = counted(self.tasks, "task")
            text += f"; {both} shared with flown policies" + (", compared there alone" if self.tasks else "")
        late = sum(any(value is None for value in each.metrics.values()) for each in self.episodes)
        text += f"; times never reached, in {counted(late, 'row')}, count as the budget" if late else ""
        left = f"; left out: {counted(self.left_out, 'row')} of another number of UAVs" if self.left_out else ""
        return f"{text}{left}."


def reported_on(comparison: Comparison) -> list[ReportedFigures]:
    """Return the reported policies of a scenario."""
    found = [ReportedFigures(comparison, policy) for policy in comparison.results.reported]
    return [each for each in found if each.count]


def reported_notes(comparison: Comparison) -> list[str]:
    """Return a sentence for each reported policy of a scenario."""
    return [each.note for each in reported_on(comparison)]


def unflown(results: Results) -> dict[str, list[ReportedFigures]]:
    """Return the reported policies of the scenarios that were not flown, by scenario."""
    names = dict.fromkeys(name for policy in results.reported for name in policy.scenarios)
    flown = {scenario for scenario, _ in results.groups}
    found = {name: reported_on(Comparison(results, name)) for name in names if name not in flown}
    return {name: figures for name, figures in found.items() if figures}


def success_text(level: float | None) -> str:
    """Return the heading of a share of successes."""
    return "reached" if level is None else f"reached {percent(level, 0 if round(100 * level, 6).is_integer() else 1)}"


def all_notes(results: Results) -> Sequence[str]:
    """Return the sentences of all reported policies of all scenarios, each with its scenario."""
    flown = {name: reported_on(Comparison(results, name)) for name in results.scenarios}
    return [f"{name}: {each.note}" for name, figures in (flown | unflown(results)).items() for each in figures]
