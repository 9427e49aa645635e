"""The first table of the page: the steps of every policy on every scenario, with ranks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.failures import failed_of
from indoor_explorers.evaluation.analysis.outliers import far_behind
from indoor_explorers.evaluation.analysis.ranks import Rank, ranks
from indoor_explorers.evaluation.analysis.reported import ReportedFigures, reported_on
from indoor_explorers.evaluation.analysis.shown_best import shown_best
from indoor_explorers.evaluation.analysis.tables.ratio_table import bounded
from indoor_explorers.evaluation.analysis.tables.reported_table import figure, success_cell
from indoor_explorers.evaluation.drawing.dot_plots import Scale, interval_plot
from indoor_explorers.evaluation.drawing.formatting import (
    EN_DASH,
    counted,
    decimals_for,
    fixed,
    interval,
    percent,
    with_interval,
)
from indoor_explorers.evaluation.drawing.palette import PolicyStyle, Styles
from indoor_explorers.evaluation.drawing.table import Cell, Column
from indoor_explorers.evaluation.statistics import Finding

#: Widths of the drawings by the number of scenarios; more scenarios have none.
WIDTHS = {1: 420, 2: 220, 3: 120}
#: Marks a policy that is significantly better or worse than the one with the lowest mean.
SIGNIFICANT = "*"
#: Marks a mean with episodes that never reached the threshold and count as their budget.
AT_LEAST = "≥"


@dataclass(frozen=True)
class LeagueCell(Cell):
    """The mean time of one policy on one scenario, with its interval."""

    rank: Rank | None = None
    """None for a policy that is not ranked, and where the tasks are too few for a test."""
    mark: str = ""
    """:data:`SIGNIFICANT`, or empty."""
    same_as: str = ""
    """The policy whose flights are the same; empty for none."""
    drawing: str | Markup = ""
    lead: str = ""
    """The difference from the lowest mean, task by task."""
    reached: str = ""
    """The share of tasks that reached the threshold."""
    failed: str = ""
    """In how many episodes the policy failed, such as ``3 of 30``; empty for none."""

    @property
    def bounded(self) -> bool:
        """Whether some episodes never reached the threshold, so that the mean is a lower bound."""
        return self.text.startswith(AT_LEAST)

    @property
    def late(self) -> str:
        """Such as ``67 % reached`` where some tasks never reached the threshold; empty where all did."""
        return f"{self.reached} reached" if self.bounded and self.reached != EN_DASH else ""


@dataclass(frozen=True)
class LeagueTable:
    """Policies by scenarios, those with the best ranks first."""

    columns: list[Column]
    """Scenarios, with what their times are for units; their keys are the sections about them."""
    rows: list[tuple[str, list[LeagueCell | None]]]
    """By policy; a cell for each scenario, None where it was not flown."""
    first: str
    """The policy with the lowest mean on the first scenario among those that are ranked; empty if none flew."""
    reported: list[tuple[str, list[LeagueCell | None]]]
    """The reported policies that have a time to a threshold, which have no rank."""

    @property
    def tested(self) -> bool:
        """Whether there are ranks."""
        return any(cell and cell.rank for _, cells in self.rows for cell in cells)

    @property
    def intervals(self) -> bool:
        """Whether any mean has an interval."""
        return any(cell and cell.detail for _, cells in self.rows for cell in cells)

    @property
    def bounded(self) -> bool:
        """Whether some episodes never reached the threshold."""
        return any(cell and cell.bounded for _, cells in self.rows for cell in cells)

    @property
    def marked(self) -> bool:
        """Whether a time has the mark of a significant difference."""
        return any(cell and cell.mark for _, cells in self.rows for cell in cells)


def league_table(comparisons: Mapping[str, Comparison], styles: Styles) -> LeagueTable:
    """Return the table; ``comparisons`` cover the common tasks, by section."""
    width = WIDTHS.get(len(comparisons), 0)
    ranked = [(each, ranks(each)) for each in comparisons.values()]
    cells = [_cells(each, places, styles, width) for each, places in ranked]
    rows = [(name, [column.get(name) for column in cells]) for name in _order(ranked)]
    firsts = [each.ranked_policies[0] if each.groups else "" for each in comparisons.values()]
    return LeagueTable(
        [_column(section, each) for section, each in comparisons.items()],
        rows,
        "".join(firsts[:1]),
        _reported(list(comparisons.values())),
    )


def _reported(comparisons: Sequence[Comparison]) -> list[tuple[str, list[LeagueCell | None]]]:
    """Return the rows of the policies whose time to the threshold of a scenario was reported."""
    found = [{each.name: _reported_cell(each) for each in reported_on(comparison)} for comparison in comparisons]
    names = dict.fromkeys(name for cells in found for name in cells)
    rows = [(name, [cells.get(name) for cells in found]) for name in names]
    return [row for row in rows if any(row[1])]


def _reported_cell(figures: ReportedFigures) -> LeagueCell | None:
    key = figures.comparison.level.key
    cell, late = figure(figures.estimate(key), key), "" if figures.complete(key).all() else AT_LEAST
    around = cell.detail or "no interval"
    text, reached = bounded(cell.text, late), success_cell(figures).text
    return LeagueCell(text, cell.value, around, reached=reached) if key in figures.metrics else None


def _column(section: str, comparison: Comparison) -> Column:
    tasks = counted(len(comparison.results.common_tasks(comparison.scenario)), "task")
    return Column(comparison.title, f"{comparison.level.title} [steps], {tasks}", section)


def _order(ranked: Sequence[tuple[Comparison, Mapping[str, Rank]]]) -> list[str]:
    """Return the policies by mean rank, then by mean place in the order of mean times; those not ranked come last."""
    found: dict[str, list[tuple[bool, int, int]]] = {}
    for comparison, places in ranked:
        for place, name in enumerate(comparison.ranking, 1):
            rank = places[name].place if name in places else place
            found.setdefault(name, []).append((not comparison.ranked(name), rank, place))
    return sorted(found, key=lambda name: [sum(parts) / len(parts) for parts in zip(*found[name], strict=True)])


def _cells(comparison: Comparison, places: Mapping[str, Rank], styles: Styles, width: int) -> dict[str, LeagueCell]:
    best = shown_best(comparison, comparison.level.key)
    scale = _scale(comparison, width)
    return {
        name: _cell(comparison, name, places.get(name), name in best, _drawn(comparison, name, scale, styles[name]))
        for name in comparison.groups
    }


def _cell(comparison: Comparison, policy: str, rank: Rank | None, best: bool, drawing: Markup) -> LeagueCell:
    time, contrast = comparison.time(policy), comparison.contrasts.get(policy)
    differs = contrast is not None and contrast.finding in (Finding.BETTER, Finding.WORSE)
    return LeagueCell(
        mean_time(comparison, policy),
        time.mean,
        interval(time, decimals_for(time.mean)),
        best,
        rank=rank,
        mark=SIGNIFICANT if differs else "",
        same_as=comparison.same_as.get(policy, ""),
        drawing=drawing,
        lead=with_interval(contrast.difference, sign=True) if contrast else "",
        reached=percent(comparison.reached(policy)),
        failed=failed_of(comparison, policy),
    )


def mean_time(comparison: Comparison, policy: str) -> str:
    """Return the mean steps to the threshold, :data:`AT_LEAST` before them where some episodes never reached it."""
    mean = comparison.time(policy).mean
    return bounded(fixed(mean, decimals_for(mean)), AT_LEAST if comparison.reached(policy) < 1 else "")


def _scale(comparison: Comparison, width: int) -> Scale | None:
    """Return a scale that holds the intervals of all policies that are not far behind."""
    far = far_behind(comparison)
    near = [comparison.time(name) for name in comparison.groups if name not in far]
    ends = [end for each in near for end in each if end is not None]
    return Scale(min(ends), max(ends), width) if width and ends else None


def _drawn(comparison: Comparison, policy: str, scale: Scale | None, style: PolicyStyle) -> Markup:
    return interval_plot(comparison.time(policy), scale, style) if scale else Markup("")
