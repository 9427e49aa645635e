"""The figure for print of every policy against the best planner of each scenario; colours say what is shown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from indoor_explorers.evaluation.analysis.best_planner import PlannerRow
from indoor_explorers.evaluation.analysis.tables.planner_table import best_steps, planner_cell, policy_columns
from indoor_explorers.evaluation.drawing.formatting import percent_as_given
from indoor_explorers.evaluation.drawing.palette import COLOURS
from indoor_explorers.evaluation.drawing.print_style import PAGE, plain
from indoor_explorers.evaluation.exports.figures.layout import add_note, paper
from indoor_explorers.evaluation.statistics import Finding

#: Inches of a row, of the names above the columns, and the most columns that a page has room for.
ROW, HEAD, MOST = 0.38, 1.15, 9
SOFT = "#555555"
#: Heights of a cell's lines by their number, in parts of the row.
HEIGHTS = {1: (0.5,), 2: (0.36, 0.72), 3: (0.26, 0.55, 0.79)}
#: Colours by what is shown; what is not resolved is hatched.
FILLS = {
    Finding.BETTER: "#a9cfe8",
    Finding.WORSE: "#f0c48a",
    Finding.AS_GOOD: "#e4e4e4",
    Finding.MIXED: "#efe9c9",
}


def planner_figures(rows: Sequence[PlannerRow]) -> list[Figure]:
    """Return the figure in as many sheets as its columns need, each with the scenarios flown there; none without rows.

    The first sheet has the policies that flew all scenarios.
    """
    policies = policy_columns(rows)
    sheets = [policies[first : first + MOST] for first in range(0, len(policies), MOST)]
    return [_sheet([row for row in rows if row.policies.keys() & set(names)], names) for names in sheets]


def _sheet(rows: Sequence[PlannerRow], policies: Sequence[str]) -> Figure:
    figure = paper(PAGE, HEAD + ROW * len(rows))
    axes = figure.add_subplot()
    for place, row in enumerate(rows):
        _label(axes, place, row)
        for column, policy in enumerate(policies):
            _draw(axes, column, place, row, policy)
    axes.set(xlim=(0, MOST), ylim=(len(rows), 0))
    axes.set_xticks([column + 0.1 for column in range(len(policies))], [plain(name, 24) for name in policies])
    axes.set_yticks([])
    axes.xaxis.tick_top()
    axes.tick_params(length=0, labelsize=7)
    learners = {name for row in rows for name, each in row.policies.items() if each.learner}
    for label, policy in zip(axes.get_xticklabels(), policies, strict=True):
        label.set(rotation=35, ha="left", rotation_mode="anchor", weight="bold" if policy in learners else None)
    for spine in axes.spines.values():
        spine.set_visible(False)
    add_note(figure, _note(rows))
    return figure


def _note(rows: Sequence[PlannerRow]) -> str:
    """Return what the figure shows, in words."""
    counts = sorted({row.best.row.tasks for row in rows})
    tasks = f"{counts[0]} to {counts[-1]}" if len(counts) > 1 else f"{counts[0]}"
    margin = percent_as_given(rows[0].margin)
    as_good = f"grey: as good within {margin} where both finish; " if rows[0].margin else ""
    return (
        f"Mean over {tasks} tasks of the steps to the threshold, divided by those of the best planner of the scenario, "
        "with 95 % bootstrap intervals; the best planner stands below the scenario, with its mean steps. Where too "
        "many episodes never reached the threshold for a ratio: the share that did. Blue: shown to be better than "
        f"the best planner; orange: worse; {as_good}yellow: faster but finishing less often, or the reverse; hatched: "
        "not resolved, with the number n of maps or tasks that would. Tests of all pairs of policies at once. "
        "Policies in bold have trained weights."
    )


def _label(axes: Axes, place: int, row: PlannerRow) -> None:
    """Write the scenario above its best planner, left of its cells."""
    below = f"{plain(row.planner, 22)}, {best_steps(row, 0)}"
    for height, text, size, colour in ((0.36, plain(row.title, 26), 7, "black"), (0.72, below, 5.5, SOFT)):
        axes.text(-0.06, place + height, text, fontsize=size, color=colour, ha="right", va="center")


def _draw(axes: Axes, column: int, place: int, row: PlannerRow, policy: str) -> None:
    """Draw a cell: the ratio, its interval, and the number of tasks that would resolve what is not."""
    found = row.policies.get(policy)
    if found is None:
        return
    fill, best = FILLS.get(found.finding) if found.finding else None, policy == row.planner
    look: dict[str, Any] = {"facecolor": fill or "white", "edgecolor": "#dddddd", "linewidth": 0.0}
    hatch = None if fill or best else "////"
    axes.add_patch(Rectangle((column + 0.03, place + 0.05), 0.94, 0.9, hatch=hatch, **look))
    if best:
        axes.add_patch(Rectangle((column + 0.05, place + 0.08), 0.9, 0.84, fill=False, edgecolor=COLOURS[0][0], lw=0.8))
    cell = planner_cell(row, policy)
    needed = f"n {found.needed:,.0f}" if found.finding is Finding.OPEN and math.isfinite(found.needed) else ""
    lines = [text for text in (cell.text, cell.detail, needed) if text]
    for place_in_cell, (text, height) in enumerate(zip(lines, HEIGHTS[len(lines)], strict=True)):
        size, colour = (5.5, SOFT) if place_in_cell else (7.5, "black")
        axes.text(column + 0.5, place + height, text, fontsize=size, color=colour, ha="center", va="center")
