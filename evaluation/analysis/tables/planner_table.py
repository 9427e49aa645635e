"""The table of every policy against the best planner of each scenario, for the page and Markdown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from indoor_explorers.evaluation.analysis.best_planner import BEST, AgainstPlanner, PlannerRow
from indoor_explorers.evaluation.analysis.tables.league_table import AT_LEAST
from indoor_explorers.evaluation.analysis.tables.ratio_table import bounded, ratio_cell
from indoor_explorers.evaluation.drawing.formatting import decimals_for, fixed, percent, percent_as_given
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row, Table, words
from indoor_explorers.evaluation.harness.episodes.metrics import MEASURES
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
    margin = rows[0].margin
    shown = f"Better, worse, and as good within {percent_as_given(margin)}" if margin else "Better and worse"
    return Table(
        [words("scenario", 14), words("best planner", 14), *map(Column, policies)],
        [Row(row.title, [_best(row), *(planner_cell(row, name) for name in policies)]) for row in rows],
        "Steps as a ratio to the best planner",
        "to_best_planner",
        [
            "Steps to the threshold of each scenario divided by those of its best planner: the policy without trained "
            "weights that has the lowest mean there. Below 1 is faster.",
            f"{shown} are shown by tests of all pairs of policies at once, as any planner could have come first, and "
            "count finished tasks too; mixed is faster but finishing less often, or the reverse; behind not resolved "
            "stands how many maps or tasks would show one of them with 80 % power, if the difference is as seen. Where "
            "too many episodes never reached the threshold for a ratio, the share that did stands for it.",
        ],
    )


def policy_columns(rows: Sequence[PlannerRow]) -> list[str]:
    """Return the policies in the order of their columns: first those of all scenarios, learners before planners."""
    flown = {name: each for row in rows for name, each in row.policies.items()}
    some = {name for name in flown if any(name not in row.policies for row in rows)}
    order = {name: (name in some, each.knows_map, not each.learner) for name, each in flown.items()}
    return sorted(order, key=order.__getitem__)


def planner_cell(row: PlannerRow, policy: str) -> PlannerCell:
    """Return the cell of a policy; empty where it did not fly."""
    if policy == row.planner:
        return PlannerCell("1", 1.0, shown=BEST)
    if policy not in row.policies:
        return PlannerCell()
    found = row.policies[policy]
    cell, shade = ratio_cell(found.row, decimals=DECIMALS), SHADES.get(found.finding, 0) if found.finding else 0
    text, detail = (cell.text, cell.detail) if found.row.censoring.bound is not None else _share(found)
    return PlannerCell(text, cell.value, detail, shade=shade, title=cell.title, shown=_said(found))


def _share(found: AgainstPlanner) -> tuple[str, str]:
    """Return what stands for a ratio where too many episodes never reached the threshold."""
    return percent(found.reached), "reached"


def best_steps(row: PlannerRow, decimals: int) -> str:
    """Return the mean steps of the best planner of a scenario, with a sign if some episodes never got there."""
    return f"{bounded(fixed(row.best.steps, decimals), AT_LEAST if row.best.reached < 1 else '')} steps"


def _said(found: AgainstPlanner) -> str:
    open_to = found.finding is Finding.OPEN and math.isfinite(found.needed)
    return f"{found.finding} ({found.needed:,.0f})" if open_to else found.finding or ""


def _best(row: PlannerRow) -> Cell:
    best = row.best
    late = f", {percent(best.reached)} reached" if best.reached < 1 else ""
    return Cell(
        row.planner, None, f"{MEASURES[best.row.metric].title} {best_steps(row, decimals_for(best.steps))}{late}"
    )
