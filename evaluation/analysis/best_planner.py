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
from indoor_explorers.evaluation.harness.results.ratios import COLUMNS, RatioRow, Ratios
from indoor_explorers.evaluation.harness.results.results import write_csv
from indoor_explorers.evaluation.statistics import Contrast

#: The columns of best_planner.csv: those of ratios.csv, and what is shown.
PLANNER_COLUMNS = (*COLUMNS, "shown", "tasks_needed")


@dataclass(frozen=True)
class AgainstPlanner:
    """A policy against the best planner of a scenario."""

    row: RatioRow
    """Steps to the threshold of the scenario, divided by the planner's."""
    contrast: Contrast
    """What tests show."""

    def cells(self) -> dict[str, Any]:
        """Return the row of best_planner.csv."""
        return {**self.row.cells(), "shown": str(self.contrast.finding), "tasks_needed": self.contrast.needed}


@dataclass(frozen=True)
class PlannerRow:
    """One scenario."""

    comparison: Comparison
    planner: str
    """Its best planner."""
    others: Mapping[str, AgainstPlanner]
    """All other policies by name."""


def is_learner(facts: Mapping[str, Any]) -> bool:
    """Return whether stored facts are those of a policy with trained weights, which its provenance names."""
    return any(key.startswith("weights") for key in facts)


def against_best_planner(comparisons: Iterable[Comparison]) -> list[PlannerRow]:
    """Return a row for each scenario in which planners and the others flew the same tasks.

    There are no rows where no learner flew, and none for a single scenario. ``comparisons`` cover the common tasks.
    """
    found = [row for row in map(_row, comparisons) if row is not None]
    learned = (is_learner(row.comparison.results.policies[name]) for row in found for name in row.others)
    return found if len(found) > 1 and any(learned) else []


def _row(comparison: Comparison) -> PlannerRow | None:
    facts = comparison.results.policies
    planners = [name for name in comparison.ranking if comparison.ranked(name) and not is_learner(facts[name])]
    if not planners or not comparison.aligned:
        return None
    best, contrasts = planners[0], comparison.contrasts_with(planners[0])
    rows = Ratios(comparison.results, [best]).of_scenario(comparison.scenario, best, comparison.level.key)
    return PlannerRow(comparison, best, {row.policy: AgainstPlanner(row, contrasts[row.policy]) for row in rows})


def write_best_planner(rows: Sequence[PlannerRow], path: Path) -> None:
    """Write best_planner.csv; equal results give equal bytes."""
    cells = [each.cells() for row in rows for each in row.others.values()]
    write_csv(pd.DataFrame(cells, columns=list(PLANNER_COLUMNS)), path, "%.6g")
