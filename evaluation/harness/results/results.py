"""Loaded results and their tables: summary.csv, one row for each episode, and estimates of the means."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.files import written_whole
from indoor_explorers.env.scenarios.suites.catalogue import buildings
from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS, MEASURES, Measure, extended, is_time
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.episodes.resimulate import recorded_scenario
from indoor_explorers.evaluation.harness.episodes.steps import StepFacts
from indoor_explorers.evaluation.harness.experiment.experiment import MARGIN, Task, declared_margin
from indoor_explorers.evaluation.harness.results.coverage_threshold import CoverageThreshold, applies_to, threshold_of
from indoor_explorers.evaluation.harness.results.fingerprints import refuse_other_fingerprints
from indoor_explorers.evaluation.harness.results.notes import ResultNotes
from indoor_explorers.evaluation.harness.results.reading import StoreReader
from indoor_explorers.evaluation.harness.results.scenario_titles import scenario_title
from indoor_explorers.evaluation.statistics import (
    Estimate,
    bootstrap_mean,
    bootstrap_means,
    interquartile_mean,
    success_share,
)

SUMMARY_COLUMNS = (
    *("policy", "scenario", "team", "metric", "episodes", "mean", "iqm", "low", "high"),
    *("success", "success_low", "success_high"),
)

#: Facts of a run about its machine.
MACHINE = ("system", "processor", "cores")


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

    @property
    def measures(self) -> Mapping[str, Measure]:
        """All metrics by key, those of plug-ins last."""
        return {**MEASURES, **self.custom_measures}

    @classmethod
    def load(cls, folder: Path, plugins: Iterable[str] = ()) -> Results:
        """Read ``folder/results.db``, which imports nothing; see ``plugins``."""
        path = folder / "results.db"
        if not path.is_file():
            raise InputError(f"{folder}: expected a folder with a results.db in it, got none; fly compare --out first")
        with StoreReader(path) as store:
            text = store.experiment()
            experiments = (text,) if text else ()
            records, scenarios = store.records(), store.scenarios()
            refuse_other_fingerprints(path, scenarios, records)
            return cls(
                *(store.policies(), scenarios, store.runs(), records, experiments, store.notes(), store.retries()),
                margin=declared_margin(text),
                plugins=frozenset(plugins),
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
        groups: dict[tuple[str, str], list[Record]] = {
            (scenario, policy): [] for scenario in self.scenarios for policy in self.policies
        }
        for record in self.records:
            groups[record.task.scenario, record.policy].append(record)
        return {key: records for key, records in groups.items() if records}

    @property
    def warnings(self) -> list[str]:
        """The notes, and a line for each fact that differs between the runs and can change results.

        Such facts are commits, versions and machines.
        """
        lines = [*self.notes, *self.retry_notes]
        for key in dict.fromkeys(key for run in self.runs for key in run if _can_change_results(key)):
            values = dict.fromkeys(str(run.get(key, "not recorded")) for run in self.runs)
            if len(values) > 1:
                effect = "; latencies do not compare" if key in MACHINE else ""
                lines.append(f"runs differ in {key}: {', '.join(values)}{effect}")
        return lines

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
        return {record.task for (name, _), records in self.groups.items() if name == scenario for record in records}

    def common_tasks(self, scenario: str) -> set[Task]:
        """Return the tasks of a scenario that all policies with episodes of it have flown."""
        groups = self.groups.items()
        flown = [{record.task for record in records} for (name, _), records in groups if name == scenario]
        return set.intersection(*flown) if flown else set()

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

    def mean_curve(self, scenario: str, policy: str) -> NDArray[np.float64]:
        """Return (T,) mean team coverage by step, up to the last step of any episode."""
        if (scenario, policy) not in self._mean_curves:
            self._mean_curves[scenario, policy] = mean_curve(self.groups[scenario, policy])
        return self._mean_curves[scenario, policy]

    @cached_property
    def _mean_curves(self) -> dict[tuple[str, str], NDArray[np.float64]]:
        return {}

    def values(self, scenario: str, policy: str, metric: str) -> NDArray[np.float64]:
        """Return (E,) values of a metric; NaN where missing; T_q never reached counts as the budget."""
        if metric == "t99_to_reference":
            return self.to_reference(scenario, policy, "t99")
        columns, records = self._columns(scenario, policy), self.groups[scenario, policy]
        told = columns.get(metric, np.full(len(records), np.nan))
        never = np.isnan(told) & [is_time(record.metrics, metric) for record in records]
        return np.where(never, [float(record.budget) for record in records], told)

    def metric_names(self, scenario: str, policy: str) -> list[str]:
        """Return the metrics that any episode of a policy has, measured or not."""
        return list(self._columns(scenario, policy))

    def _columns(self, scenario: str, policy: str) -> dict[str, NDArray[np.float64]]:
        """Return (E,) what is stored of each metric; NaN where missing."""
        if (scenario, policy) not in self._metrics:
            records = self.groups[scenario, policy]
            found: defaultdict[str, NDArray[np.float64]] = defaultdict(lambda: np.full(len(records), np.nan))
            for place, record in enumerate(records):
                for metric, value in record.metrics.items():
                    found[metric][place] = np.nan if value is None else value
            self._metrics[scenario, policy] = dict(found)
        return self._metrics[scenario, policy]

    @cached_property
    def _metrics(self) -> dict[tuple[str, str], dict[str, NDArray[np.float64]]]:
        return {}

    def to_reference(self, scenario: str, policy: str, metric: str) -> NDArray[np.float64]:
        """Return (E,) values of T_q / T_q of the reference; NaN where there is none or the goal is below q.

        The reference is the first policy that knows the map and flew the task.
        """
        records = self.groups[scenario, policy]
        known = self.references.get(scenario, {}) if self.applies_to(scenario, metric) else {}
        if not known:
            return np.full(len(records), np.nan)
        least = [_value(known[record.task], metric) if record.task in known else 0.0 for record in records]
        values = self.values(scenario, policy, metric).tolist()
        return np.array([value / (b or np.nan) for value, b in zip(values, least, strict=True)], np.float64)

    def maps(self, scenario: str, policy: str) -> NDArray[np.str_]:
        """Return (E,) which map each episode was flown on; equal maps have equal labels, whatever their files.

        Maps that suites say are of one building have one label, as they are alike.
        """
        known = buildings()
        digests = [record.floorplan.digest for record in self.groups[scenario, policy]]
        return np.array([known.get(digest, digest) for digest in digests])

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
        records = self.groups[scenario, policy]
        if metric in LEVELS:
            return self.measured(scenario, policy, metric)
        return np.array([record.outcome is Outcome.COMPLETE for record in records])

    def measured(self, scenario: str, policy: str, metric: str) -> NDArray[np.bool_]:
        """Return (E,) whether each episode has a value of a metric; T_q has none where it was never reached."""
        missing = np.full(len(self.groups[scenario, policy]), np.nan)
        return ~np.isnan(self._columns(scenario, policy).get(metric, missing))

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

    def estimates(self, scenario: str, policy: str) -> dict[str, Estimate]:
        """Return the mean of every metric that was measured, with its interval: maps are drawn, then episodes."""
        if (scenario, policy) not in self._estimates:
            self._estimates[scenario, policy] = self._estimated(scenario, policy)
        return self._estimates[scenario, policy]

    @cached_property
    def _estimates(self) -> dict[tuple[str, str], dict[str, Estimate]]:
        return {}

    def _estimated(self, scenario: str, policy: str) -> dict[str, Estimate]:
        """Estimate the metrics that all episodes have from one set of resamples, the others one by one."""
        extra = sorted(self._columns(scenario, policy).keys() - set(MEASURES))
        values = {metric: self.values(scenario, policy, metric) for metric in (*MEASURES, *extra)}
        maps = self.maps(scenario, policy)
        held = {metric: ~np.isnan(column) for metric, column in values.items()}
        whole = [metric for metric in values if held[metric].all()]
        found = dict(zip(whole, bootstrap_means(np.stack([values[m] for m in whole], axis=1), maps=maps), strict=True))
        for metric, there in held.items():
            if there.any() and metric not in found:
                found[metric] = bootstrap_mean(values[metric][there], maps=maps[there])
        return {metric: found[metric] for metric in values if metric in found}

    def episodes(self) -> pd.DataFrame:
        """Return one row per episode: its task, outcome, steps and metrics."""
        return pd.DataFrame(
            self._episode_row(record, ratio)
            for scenario, policy in self.groups
            for record, ratio in zip(
                self.groups[scenario, policy], self.values(scenario, policy, "t99_to_reference"), strict=True
            )
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


def mean_curve(records: Sequence[Record]) -> NDArray[np.float64]:
    """Return (T,) mean team coverage by step, each curve constant after its end.

    One episode is read at a time, and its facts are kept for later.
    """
    total = np.zeros(1 + max(record.steps for record in records))
    for record in records:
        curve, _ = record.curve, record.facts
        total[: len(curve)] += curve
        total[len(curve) :] += curve[-1]
    return total / len(records)


def _can_change_results(key: str) -> bool:
    return key in (*MACHINE, "commit", "python") or key.endswith(" version")


def _value(record: Record, metric: str) -> float:
    value = record.metrics.get(metric)
    if value is None:
        return float(record.budget) if is_time(record.metrics, metric) else np.nan
    return value


def write_summary(results: Results, path: Path) -> None:
    """Write summary.csv; equal results give equal bytes."""
    with written_whole(path) as partial:
        results.summary().to_csv(partial, index=False, float_format="%.6g", lineterminator="\n")
