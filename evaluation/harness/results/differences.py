"""Steps and AUC of each policy minus those of a baseline policy, task by task, for each scenario."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS
from indoor_explorers.evaluation.harness.results.coverage_threshold import drawn
from indoor_explorers.evaluation.harness.results.results import Results, write_csv
from indoor_explorers.evaluation.statistics import Contrast, Finding, contrasts

COLUMNS = (
    *("scenario", "policy", "minus", "metric", "tasks", "difference", "low", "high"),
    *("better", "equal", "worse", "p", "adjusted_p", "significant"),
    *("both_finished", "success_p", "margin", "equivalence_p", "finding", "needed"),
)


@dataclass(frozen=True)
class DifferenceRow:
    """One metric of a policy minus that of a baseline, on the tasks that all policies flew."""

    scenario: str
    policy: str
    minus: str
    metric: str
    contrast: Contrast

    def cells(self) -> dict[str, Any]:
        """Return the row of differences.csv."""
        found = self.contrast
        names = (self.scenario, self.policy, self.minus, self.metric, found.pairs)
        tests = (found.p_value, found.adjusted_p, found.shown)
        needed = found.needed if found.finding is Finding.OPEN else None
        more = (found.both, found.success_p, found.margin, found.equivalence_p, found.finding, needed)
        return dict(zip(COLUMNS, (*names, *found.difference, *found.tally, *tests, *more), strict=True))


def difference_metrics(results: Results) -> tuple[str, ...]:
    """Return the times that are compared, T90 and those to the thresholds of the scenarios, and the AUC."""
    return (*drawn(results.levels), "auc")


def differences(results: Results, baselines: Sequence[str]) -> list[DifferenceRow]:
    """Compare all policies with each baseline, by baseline, metric and scenario.

    Times are compared over the tasks that both finished. The p-values of a metric on a scenario are adjusted by Holm's
    method over the policies compared with one baseline; policies that are not ranked, as they know the map or failed a
    check, are a family of their own. The margin of equivalence is that of the results, for times alone.
    """
    common = results.on_common_tasks
    return [
        row
        for minus in baselines
        for metric in difference_metrics(common)
        for scenario in common.scenarios
        if (scenario, minus) in common.groups and common.applies_to(scenario, metric)
        for row in _rows(common, scenario, minus, metric)
    ]


def _rows(results: Results, scenario: str, minus: str, metric: str) -> Iterator[DifferenceRow]:
    others = [name for name in results.policies if name != minus and (scenario, name) in results.groups]
    if not all(len(results.groups[scenario, name]) == len(results.groups[scenario, minus]) for name in others):
        return  # no common tasks
    maps = results.maps(scenario, minus)
    unranked = {*results.privileged_policies, *results.failed_checks}
    for family in ([name for name in others if name not in unranked], [name for name in others if name in unranked]):
        values = {name: results.values(scenario, name, metric) for name in (minus, *family)}
        reached = {name: results.reached(scenario, name, metric) for name in values} if metric in LEVELS else None
        margin, less = (results.margin, True) if metric in LEVELS else (0.0, False)
        found = contrasts(values, minus, maps=maps, lower_is_better=less, reached=reached, margin=margin)
        for policy, contrast in found.items():
            yield DifferenceRow(scenario, policy, minus, metric, contrast)


def write_differences(rows: Sequence[DifferenceRow], path: Path) -> None:
    """Write differences.csv; equal results give equal bytes."""
    write_csv(pd.DataFrame([row.cells() for row in rows], columns=list(COLUMNS)), path, "%.6g")
