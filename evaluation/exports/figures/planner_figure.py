"""The figure for print of every policy against the best planner of each scenario; colours say what is shown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from indoor_explorers.evaluation.analysis.best_planner import PlannerRow, is_learner
from indoor_explorers.evaluation.analysis.tables.planner_table import planner_cell, policy_columns
from indoor_explorers.evaluation.drawing.formatting import fixed, percent_as_given
from indoor_explorers.evaluation.drawing.palette import COLOURS
from indoor_explorers.evaluation.drawing.print_style import PAGE, plain
from indoor_explorers.evaluation.exports.figures.layout import add_note, paper
from indoor_explorers.evaluation.statistics import Finding

#: Inches of a row, of the names above the columns, and the most columns that a page has room for.
ROW, HEAD, MOST = 0.34, 1.15, 9
SOFT = "#555555"
#: Colours by what is shown; what is not resolved is hatched.
FILLS = {
    Finding.BETTER: "#a9cfe8",
    Finding.WORSE: "#f0c48a",
    Finding.AS_GOOD: "#e4e4e4",
    Finding.MIXED: "#efe9c9",
}


def planner_figures(rows: Sequence[PlannerRow]) -> list[Figure]:
    """Return the figure in as many sheets as its columns need; none without rows."""
    policies = policy_columns(rows) if rows else []
    return [_sheet(rows, policies[first : first + MOST]) for first in range(0, len(policies), MOST)]


def _sheet(rows: Sequence[PlannerRow], policies: Sequence[str]) -> Figure:
    figure = paper(PAGE, HEAD + ROW * len(rows))
    axes = figure.add_subplot()
    for place, row in enumerate(rows):
        for column, policy in enumerate(policies):
            _draw(axes, column, place, row, policy)
    facts, margin = rows[0].comparison.results.policies, percent_as_given(rows[0].comparison.results.margin)
    axes.set(xlim=(0, len(policies)), ylim=(len(rows), 0))
    axes.set_xticks([column + 0.1 for column in range(len(policies))], [plain(name, 24) for name in policies])
    axes.set_yticks([place + 0.5 for place in range(len(rows))], [plain(row.comparison.title, 26) for row in rows])
    axes.xaxis.tick_top()
    axes.tick_params(length=0, labelsize=7)
    for label, policy in zip(axes.get_xticklabels(), policies, strict=True):
        label.set(rotation=35, ha="left", rotation_mode="anchor", weight="bold" if is_learner(facts[policy]) else None)
    for spine in axes.spines.values():
        spine.set_visible(False)
    add_note(
        figure,
        "Mean over tasks of the steps to the threshold, divided by those of the best planner of the scenario, with "
        "95 % bootstrap intervals. Blue: shown to be better than it; orange: worse; grey: as good within "
        f"{margin}; yellow: faster but finishing less often, or the reverse; "
        "hatched: not resolved; framed: the best planner, with its mean steps. Tests of all pairs of policies at once. "
        "Policies in bold have trained weights.",
    )
    return figure


def _draw(axes: Axes, column: int, place: int, row: PlannerRow, policy: str) -> None:
    """Draw a cell: the ratio above its interval."""
    found, best = row.others.get(policy), policy == row.planner
    if found is None and not best:
        return
    fill = FILLS.get(found.contrast.finding) if found else None
    look: dict[str, Any] = {"facecolor": fill or "white", "edgecolor": "#dddddd", "linewidth": 0.0}
    hatch = None if fill or best else "////"
    axes.add_patch(Rectangle((column + 0.03, place + 0.05), 0.94, 0.9, hatch=hatch, **look))
    if best:
        axes.add_patch(Rectangle((column + 0.05, place + 0.08), 0.9, 0.84, fill=False, edgecolor=COLOURS[0][0], lw=0.8))
    cell = planner_cell(row, policy)
    below = cell.detail if found else f"{fixed(row.comparison.time(policy).mean, 0)} steps"
    for height, text, size, colour in ((0.34, cell.text, 7.5, "black"), (0.72, below, 5.5, SOFT)):
        axes.text(column + 0.5, place + height, text, fontsize=size, color=colour, ha="center", va="center")
