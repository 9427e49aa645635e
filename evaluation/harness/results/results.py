"""Loaded results and their tables: summary.csv, one row for each episode, and estimates of the means."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.files import written_whole
from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS, MEASURES, TIMES, Measure, extended
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record, mean_curve
from indoor_explorers.evaluation.harness.episodes.resimulate import recorded_scenario
from indoor_explorers.evaluation.harness.episodes.steps import StepFacts
from indoor_explorers.evaluation.harness.experiment.experiment import MARGIN, Task, declared_margin
from indoor_explorers.evaluation.harness.reported.rows import ReportedPolicy, joined, read_reported
from indoor_explorers.evaluation.harness.results.coverage_threshold import CoverageThreshold, applies_to, threshold_of
from indoor_explorers.evaluation.harness.results.fingerprints import refuse_other_fingerprints
from indoor_explorers.evaluation.harness.results.map_labels import map_labels
from indoor_explorers.evaluation.harness.results.notes import ResultNotes
from indoor_explorers.evaluation.harness.results.origins import Origin
from indoor_explorers.evaluation.harness.results.reading import StoreReader
from indoor_explorers.evaluation.harness.results.scenario_titles import scenario_title
from indoor_explorers.evaluation.statistics import Estimate, interquartile_mean, success_share
from indoor_explorers.evaluation.statistics.means import means_of_measured

SUMMARY_COLUMNS = (
    *("policy", "scenario", "team", "metric", "episodes", "mean", "iqm", "low", "high"),
    *("success", "success_low", "success_high"),
)


@dataclass(frozen=True, eq=False)
class Results(ResultNotes):
    """Everything a store holds, loaded."""

    policies: dict[str, dict[str, Any]]
    """Facts of each policy by name, in table order."""
    scenarios: dict[str, dict[str, Any]]
    """Settings of each scenario by name, in table order."""
    runs: list[dict[str, Any]]
    """Facts of each run, oldest first."""
    records: list[Record]
    experiments: tuple[str, ...] = ()
    """The experiment of each store in TOML, with every policy that any of its runs flew."""
    notes: tuple[str, ...] = ()
    """Lines on what happened to the stores."""
    retries: Mapping[tuple[str, Task], int] = field(default_factory=dict)
    """How often episodes were flown again after a failure, of those that were."""
    custom_measures: Mapping[str, Measure] = field(default_factory=dict)
    """Metrics of plug-ins by key, see :func:`~.custom_metrics.with_metrics`."""
    margin: float = MARGIN
    """By which share a mean time may exceed another for the two to count as equally good; 0 for no such statement."""
    plugins: frozenset[str] = frozenset()
    """What may be imported of the models and policies from outside this package that the results name."""
    reported: tuple[ReportedPolicy, ...] = ()
    """Policies that others flew, whose rows were imported; they have no records and take part in no test."""
    origins: Mapping[str, Origin] = field(default_factory=dict)
    """Source and kind of maps by their digests, of those that have them stored."""

    @property
    def measures(self) -> Mapping[str, Measure]:
        """All metrics by key, those of plug-ins last."""
        return {**MEASURES, **self.custom_measures}

    @classmethod
    def load(cls, folder: Path, plugins: Iterable[str] = ()) -> Results:
        """Read ``folder/results.db``, which imports nothing (see ``plugins``), and the reported rows beside it."""
        path, reported = folder / "results.db", read_reported(folder)
        if not path.is_file():
            if reported:
                return cls({}, {}, [], [], reported=reported)
            raise InputError(f"{folder}: expected a folder with a results.db in it, got none; fly compare --out first")
        with StoreReader(path) as store:
            experiments = (text,) if (text := store.experiment()) else ()
            policies, records, scenarios = store.policies(), store.records(), store.scenarios()
            refuse_other_fingerprints(path, scenarios, records)
            return cls(
                *(policies, scenarios, store.runs(), records, experiments, store.notes(), store.retries()),
                margin=declared_margin(text),
                plugins=frozenset(plugins),
                reported=joined(reported, policies),
                origins=store.origins(),
            )

    def scenario(self, name: str) -> Scenario:
        """Return a stored scenario without its maps; one that needs what is not in ``plugins`` is refused."""
        return recorded_scenario(self.scenarios[name], self.plugins)

    def title(self, name: str) -> str:
        """Return what a scenario is called in titles: its name, and what differs from the preset of that name."""
        return scenario_title(name, self.scenarios[name]) if name in self.scenarios else name

    @cached_property
    def groups(self) -> dict[tuple[str, str], list[Record]]:
        """The records by (scenario, policy), each list ordered by task."""
        found: defaultdict[tuple[str, str], list[Record]] = defaultdict(list)
        for record in self.records:
            found[record.task.scenario, record.policy].append(record)
        return {key: found[key] for key in product(self.scenarios, self.policies) if key in found}

    def level(self, scenario: str) -> CoverageThreshold:
        """Return the coverage threshold of a scenario."""
        return threshold_of(self._goal(scenario))

    @property
    def levels(self) -> list[CoverageThreshold]:
        """The coverage threshold of each scenario, in table order."""
        return [self.level(scenario) for scenario in self.scenarios]

    def applies_to(self, scenario: str, metric: str) -> bool:
        """Return whether a metric can be measured at a scenario's goal; T99 cannot at a goal of 90 %."""
        return applies_to(self._goal(scenario), metric)

    def _goal(self, scenario: str) -> float:
        return float(self.scenarios[scenario].get("goal", 1.0))

    def tasks(self, scenario: str) -> set[Task]:
        """Return the tasks of a scenario that any policy has flown."""
        return set().union(*self._flown(scenario))

    def common_tasks(self, scenario: str) -> set[Task]:
        """Return the tasks of a scenario that all policies with episodes of it have flown."""
        flown = self._flown(scenario)
        return set.intersection(*flown) if flown else set()

    def _flown(self, scenario: str) -> list[set[Task]]:
        return [{record.task for record in records} for (name, _), records in self.groups.items() if name == scenario]

    @cached_property
    def on_common_tasks(self) -> Results:
        """The results of the common tasks of each scenario, which all tables compare; of all where there is none."""
        kept = {scenario: self.common_tasks(scenario) or self.tasks(scenario) for scenario in self.scenarios}
        records = [record for record in self.records if record.task in kept[record.task.scenario]]
        return self if len(records) == len(self.records) else replace(self, records=records)

    def curves(self, scenario: str, policy: str, who: str = "team") -> NDArray[np.float64]:
        """Return (E, T + 1) coverage by step of ``who`` (see :meth:`Record.coverage`), constant after the end."""
        records = self.groups[scenario, policy]
        length = 1 + max(record.budget for record in records)
        return np.stack([extended(record.coverage(who), length) for record in records])

    def facts(self, scenario: str, policy: str) -> list[StepFacts]:
        """Return what reports need of the steps of each episode."""
        self.mean_curve(scenario, policy)  # reads the steps too, and once is enough
        return [record.facts for record in self.groups[scenario, policy]]

    @cached_property
    def mean_curve(self) -> Callable[[str, str], NDArray[np.float64]]:
        """Function of (scenario, policy): (T,) mean team coverage by step, up to the last step of any episode."""
        return cache(lambda scenario, policy: mean_curve(self.groups[scenario, policy]))

    def values(self, scenario: str, policy: str, metric: str) -> NDArray[np.float64]:
        """Return (E,) values of a metric; NaN where missing; T_q never reached counts as the budget."""
        if metric == "t99_to_reference":
            return self.to_reference(scenario, policy, "t99")
        stored, records = self._stored(scenario, policy, metric), self.groups[scenario, policy]
        if metric not in TIMES:
            return stored
        never = np.isnan(stored)
        if metric not in LEVELS:  # times that only some episodes have
            never &= [metric in record.metrics for record in records]
        return np.where(never, [float(record.budget) for record in records], stored)

    def metric_names(self, scenario: str, policy: str) -> list[str]:
        """Return the metrics that any episode of a policy has, measured or not."""
        return list(self._columns(scenario, policy))

    def _stored(self, scenario: str, policy: str, metric: str) -> NDArray[np.float64]:
        """Return a copy of the (E,) stored values of a metric; NaN where missing."""
        found = self._columns(scenario, policy).get(metric)
        return np.full(len(self.groups[scenario, policy]), np.nan) if found is None else found.copy()

    @cached_property
    def _columns(self) -> Callable[[str, str], dict[str, NDArray[np.float64]]]:
        """Function of (scenario, policy): (E,) stored values by metric; NaN where missing."""

        def columns(scenario: str, policy: str) -> dict[str, NDArray[np.float64]]:
            table = pd.DataFrame([record.metrics for record in self.groups[scenario, policy]])
            return {str(metric): column.to_numpy(np.float64) for metric, column in table.items()}

        return cache(columns)

    def to_reference(self, scenario: str, policy: str, metric: str) -> NDArray[np.float64]:
        """Return (E,) values of T_q / T_q of the reference; NaN where there is none or the goal is below q.

        The reference is the first policy that knows the map and flew the task.
        """
        known: dict[Task, float] = {}
        for name in reversed(self.privileged_policies if self.applies_to(scenario, metric) else []):
            if records := self.groups.get((scenario, name)):
                times = self.values(scenario, name, metric).tolist()
                known |= {record.task: time for record, time in zip(records, times, strict=True)}
        least = np.array([known.get(record.task, 0.0) or np.nan for record in self.groups[scenario, policy]])
        return np.asarray(self.values(scenario, policy, metric) / least)

    def maps(self, scenario: str, policy: str) -> NDArray[np.str_]:
        """Return (E,) the label of each episode's map; maps that count as one have one label (:func:`map_labels`)."""
        labels = self._labels(scenario)
        return np.array([labels[record.floorplan.digest] for record in self.groups[scenario, policy]])

    @cached_property
    def _labels(self) -> Callable[[str], dict[str, str]]:
        return cache(lambda name: map_labels(self.records, name, self.scenarios[name]["map"]["source"]))

    @cached_property
    def references(self) -> dict[str, dict[Task, Record]]:
        """By scenario, the record of each task by the first policy that knows the map; empty without one."""
        found: dict[str, dict[Task, Record]] = {}
        for policy in reversed(self.privileged_policies):
            for scenario in self.scenarios:
                records = self.groups.get((scenario, policy), [])
                found.setdefault(scenario, {}).update({record.task: record for record in records})
        return found

    def reached(self, scenario: str, policy: str, metric: str) -> NDArray[np.bool_]:
        """Return (E,) whether each episode reached T_q, or for other metrics the scenario's goal."""
        if metric in LEVELS:
            return self.measured(scenario, policy, metric)
        return np.array([record.outcome is Outcome.COMPLETE for record in self.groups[scenario, policy]])

    def measured(self, scenario: str, policy: str, metric: str) -> NDArray[np.bool_]:
        """Return (E,) whether each episode has a value of a metric; T_q has none where it was never reached."""
        return ~np.isnan(self._stored(scenario, policy, metric))

    def success(self, scenario: str, policy: str, metric: str) -> Estimate:
        """Return the share of episodes that :meth:`reached` it with its exact interval."""
        return success_share(self.reached(scenario, policy, metric))

    def summary(self) -> pd.DataFrame:
        """Return one row per scenario, policy and metric with the columns of summary.csv, over the common tasks."""
        return pd.DataFrame(self.on_common_tasks._summary_rows(), columns=list(SUMMARY_COLUMNS))

    def _summary_rows(self) -> Iterator[tuple[Any, ...]]:
        for (scenario, policy), records in self.groups.items():
            for metric, (mean, low, high) in self.estimates(scenario, policy).items():
                values = self.values(scenario, policy, metric)
                values = values[~np.isnan(values)]
                yield (
                    *(policy, scenario, records[0].team, metric, len(values), mean, interquartile_mean(values)),
                    *(low, high, *self.success(scenario, policy, metric)),
                )

    @cached_property
    def estimates(self) -> Callable[[str, str], dict[str, Estimate]]:
        """Function of (scenario, policy): the mean of every measured metric, with its interval.

        Maps are drawn, then episodes.
        """
        return cache(self._estimated)

    def _estimated(self, scenario: str, policy: str) -> dict[str, Estimate]:
        extra = sorted(self._columns(scenario, policy).keys() - set(MEASURES))
        values = {metric: self.values(scenario, policy, metric) for metric in (*MEASURES, *extra)}
        return means_of_measured(values, self.maps(scenario, policy))

    def episodes(self) -> pd.DataFrame:
        """Return one row per episode: its task, outcome, steps and metrics."""
        return pd.DataFrame(
            self._episode_row(record, ratio)
            for key, records in self.groups.items()
            for record, ratio in zip(records, self.to_reference(*key, "t99"), strict=True)
        )

    def _episode_row(self, record: Record, ratio: float) -> dict[str, Any]:
        return {
            "policy": record.policy,
            "scenario": record.task.scenario,
            "map": record.floorplan.name,
            "map_index": record.task.map_index,
            "seed": record.task.seed,
            "team": record.team,
            "budget": record.budget,
            "reachable": record.reachable,
            "outcome": str(record.outcome),
            "reason": record.reason,
            "steps": record.steps,
            **record.metrics,
            **({"t99_to_reference": ratio} if self.references else {}),
            **({"retries": self.retries.get((record.policy, record.task), 0)} if self.retries else {}),
        }


def write_summary(results: Results, path: Path) -> None:
    """Write summary.csv; equal results give equal bytes."""
    write_csv(results.summary(), path, "%.6g")


def write_csv(table: pd.DataFrame, path: Path, float_format: str | None = None) -> None:
    """Write a table without its index."""
    with written_whole(path) as partial:
        table.to_csv(partial, index=False, float_format=float_format, lineterminator="\n")
