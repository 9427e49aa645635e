"""The table of every policy against the best planner of each scenario, for the page and Markdown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from indoor_explorers.evaluation.analysis.best_planner import AgainstPlanner, PlannerRow, is_learner
from indoor_explorers.evaluation.analysis.tables.league_table import mean_time
from indoor_explorers.evaluation.analysis.tables.ratio_table import ratio_cell
from indoor_explorers.evaluation.drawing.formatting import percent, percent_as_given
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row, Table, words
from indoor_explorers.evaluation.statistics import Finding

#: Decimals of a ratio.
DECIMALS = 2
#: Shades by what is shown.
SHADES = {Finding.BETTER: 3, Finding.WORSE: -3}


@dataclass(frozen=True)
class PlannerCell(Cell):
    """A ratio with its interval."""

    shown: str = ""
    """What tests show, in words, with the number of maps or tasks that would, where nothing is resolved."""

    @property
    def line(self) -> str:
        """The ratio with its interval and what is shown."""
        return f"{super().line} {self.shown}".strip()


def planner_table(rows: Sequence[PlannerRow]) -> Table | None:
    """Return a table of scenarios by policies, learners first and those that know the map last; None without rows.

    A cell has the mean over tasks of the ratio of steps to those of the best planner, with its interval, and what the
    tests show.
    """
    if not rows:
        return None
    policies = policy_columns(rows)
    margin = rows[0].comparison.results.margin
    shown = f"Better, worse, and as good within {percent_as_given(margin)}" if margin else "Better and worse"
    return Table(
        [words("scenario", 14), words("best planner", 14), *map(Column, policies)],
        [Row(row.comparison.title, [_best(row), *(planner_cell(row, name) for name in policies)]) for row in rows],
        "Steps as a ratio to the best planner",
        "to_best_planner",
        [
            "Steps to the threshold of each scenario divided by those of its best planner: the policy without trained "
            "weights that has the lowest mean there. Below 1 is faster.",
            f"{shown} are shown by tests of all pairs of policies at once, as any planner could have come first, and "
            "count finished tasks too; mixed is faster but finishing less often, or the reverse; behind not resolved "
            "stands how many maps or tasks would show one of them with 80 % power, if the difference is as seen.",
        ],
    )


def policy_columns(rows: Sequence[PlannerRow]) -> list[str]:
    """Return the policies in the order of their columns."""
    comparison, facts = rows[0].comparison, rows[0].comparison.results.policies
    flown = [name for name in facts if any(name in (row.planner, *row.others) for row in rows)]
    return sorted(flown, key=lambda name: (comparison.privileged(name), not is_learner(facts[name])))


def planner_cell(row: PlannerRow, policy: str) -> PlannerCell:
    """Return the cell of a policy; empty where it did not fly."""
    if policy == row.planner:
        return PlannerCell("1", 1.0, shown="best planner")
    if policy not in row.others:
        return PlannerCell()
    found = row.others[policy]
    cell, finding = ratio_cell(found.row, decimals=DECIMALS), found.contrast.finding
    return PlannerCell(
        cell.text, cell.value, cell.detail, shade=SHADES.get(finding, 0), title=cell.title, shown=_said(found)
    )


def _said(found: AgainstPlanner) -> str:
    contrast = found.contrast
    if contrast.finding is Finding.OPEN and contrast.difference.low is None:
        return ""
    enough = contrast.finding is Finding.OPEN and math.isfinite(contrast.needed)
    return f"{contrast.finding} ({contrast.needed:,.0f})" if enough else contrast.finding


def _best(row: PlannerRow) -> Cell:
    reached = row.comparison.reached(row.planner)
    late = f", {percent(reached)} reached" if reached < 1 else ""
    return Cell(row.planner, None, f"{row.comparison.level.title} {mean_time(row.comparison, row.planner)} steps{late}")
