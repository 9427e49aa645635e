"""Every policy against the best planner of each scenario: where learning pays, and where it does not.

The best planner of a scenario is the ranked policy without trained weights that has the lowest mean time there. It is
chosen by the same episodes, so all pairs of policies are tested at once, as any planner could have been the best.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.harness.results.ratios import COLUMNS, FIGURES, NEVER, Censoring, RatioRow, Ratios
from indoor_explorers.evaluation.harness.results.results import write_csv
from indoor_explorers.evaluation.statistics import Contrast, Estimate, Finding, PairedRatio

#: What best_planner.csv says of the best planner itself, and of a policy that was not tested.
BEST, UNTESTED = "best planner", "not tested"
#: The columns of best_planner.csv: those of ratios.csv, and what is shown.
PLANNER_COLUMNS = (*COLUMNS, "shown", "tasks_needed", "steps", "reached", "learner", "knows_map", "margin")
#: The ratio of a policy to itself.
ITSELF = PairedRatio(*[Estimate(1.0, 1.0, 1.0)] * 2)


@dataclass(frozen=True)
class AgainstPlanner:
    """A policy against the best planner of a scenario."""

    row: RatioRow
    """Steps to the threshold of the scenario, divided by the planner's."""
    finding: Finding | None
    """What tests show; None for the best planner itself, and for too few tasks to test."""
    needed: float
    """Maps, or tasks, that would resolve what is not resolved."""
    steps: float
    """Mean steps to the threshold; an episode that never reached it counts as its budget."""
    reached: float
    """Share of the episodes that reached it."""
    learner: bool
    knows_map: bool

    def cells(self, margin: float) -> dict[str, Any]:
        """Return the row of best_planner.csv; ``margin`` is that within which two policies are as good."""
        untested = BEST if self.row.policy == self.row.to else UNTESTED
        shown = (untested if self.finding is None else str(self.finding), self.needed, self.steps, self.reached)
        last = (self.learner, self.knows_map, margin)
        return {**self.row.cells(), **dict(zip(PLANNER_COLUMNS[len(COLUMNS) :], (*shown, *last), strict=True))}


@dataclass(frozen=True)
class PlannerRow:
    """One scenario."""

    title: str
    planner: str
    """Its best planner."""
    margin: float
    """Share within which two policies are as good."""
    policies: Mapping[str, AgainstPlanner]
    """All policies by name, the best planner too."""

    @property
    def best(self) -> AgainstPlanner:
        """The best planner, against itself."""
        return self.policies[self.planner]


def is_learner(facts: Mapping[str, Any]) -> bool:
    """Return whether stored facts are those of a policy with trained weights, which its provenance names.

    One whose parameter ``network`` is off flies as the planner from which its training starts.
    """
    return any(key.startswith("weights") for key in facts) and facts.get("parameters", {}).get("network") != "False"


def against_best_planner(comparisons: Iterable[Comparison]) -> list[PlannerRow]:
    """Return a row for each scenario in which planners and the others flew the same tasks.

    There are no rows where no learner flew, and none for a single scenario. ``comparisons`` cover the common tasks.
    """
    found = [row for row in map(_row, comparisons) if row is not None]
    learned = (each.learner for row in found for each in row.policies.values())
    return found if len(found) > 1 and any(learned) else []


def _row(comparison: Comparison) -> PlannerRow | None:
    facts = comparison.results.policies
    planners = [name for name in comparison.ranking if comparison.ranked(name) and not is_learner(facts[name])]
    if not planners or not comparison.aligned:
        return None
    best, level = planners[0], comparison.level.key
    rows = {row.policy: row for row in Ratios(comparison.results, [best]).of_scenario(comparison.scenario, best, level)}
    tasks = len(comparison.groups[best])
    rows[best] = RatioRow(comparison.scenario, best, best, level, 1, tasks, ITSELF, Censoring(tasks, 0, 0, 0))
    tests = comparison.contrasts_with(best)
    found = {name: _against(comparison, rows[name], tests.get(name)) for name in facts if name in rows}
    return PlannerRow(comparison.title, best, comparison.results.margin, found)


def _against(comparison: Comparison, row: RatioRow, test: Contrast | None) -> AgainstPlanner:
    untested = test is None or (test.finding is Finding.OPEN and test.difference.low is None)
    return AgainstPlanner(
        row,
        None if test is None or untested else test.finding,
        float("nan") if test is None else test.needed,
        comparison.time(row.policy).mean,
        comparison.reached(row.policy),
        is_learner(comparison.results.policies[row.policy]),
        comparison.privileged(row.policy),
    )


def write_best_planner(rows: Sequence[PlannerRow], path: Path) -> None:
    """Write best_planner.csv; equal results give equal bytes."""
    cells = [each.cells(row.margin) for row in rows for each in row.policies.values()]
    write_csv(pd.DataFrame(cells, columns=list(PLANNER_COLUMNS)), path, "%.6g")


def read_best_planner(path: Path) -> list[PlannerRow]:
    """Return the rows of a best_planner.csv; scenarios stand for their titles."""
    table = pd.read_csv(path)
    return [_read_row(str(name), each) for name, each in table.groupby("scenario", sort=False)]


def _read_row(scenario: str, table: pd.DataFrame) -> PlannerRow:
    policies = {str(line["policy"]): _read(line) for line in table.to_dict("records")}
    return PlannerRow(scenario, str(table["to"].iloc[0]), float(table["margin"].iloc[0]), policies)


def _read(line: Mapping[Any, Any]) -> AgainstPlanner:
    ends = [float(line[name]) for name in FIGURES]
    ratio = PairedRatio(_estimate(*ends[:3]), _estimate(*ends[3:]))
    above, below, both = (int(line[name]) for name in NEVER[:3])
    censoring = Censoring(int(line["tasks"]), above, below, both)
    scenario, policy, to, metric = (str(line[name]) for name in COLUMNS[:4])
    return AgainstPlanner(
        RatioRow(scenario, policy, to, metric, int(line["scenarios"]), int(line["tasks"]), ratio, censoring),
        None if line["shown"] in (BEST, UNTESTED) else Finding(line["shown"]),
        float(line["tasks_needed"]),
        float(line["steps"]),
        float(line["reached"]),
        bool(line["learner"]),
        bool(line["knows_map"]),
    )


def _estimate(mean: float, low: float, high: float) -> Estimate:
    return Estimate(mean, None, None) if low != low else Estimate(mean, low, high)
