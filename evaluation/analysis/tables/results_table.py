"""The results table of a scenario, a row for each policy, and the table of its other measures, a row for each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.failures import failed
from indoor_explorers.evaluation.analysis.outliers import far_behind
from indoor_explorers.evaluation.analysis.shown_best import shown_best
from indoor_explorers.evaluation.drawing.dot_plots import Scale, episode_dot_plot
from indoor_explorers.evaluation.drawing.formatting import decimals_for, fixed, interval, percent, percent_interval
from indoor_explorers.evaluation.drawing.palette import Styles
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row
from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS, WASTED, tolerated_steps
from indoor_explorers.evaluation.harness.results.coverage_threshold import CoverageThreshold, tabled
from indoor_explorers.evaluation.statistics import Estimate


@dataclass(frozen=True)
class MeasureColumn(Column):
    """A column of the results table; its key is a metric, or a time with what is made from it."""

    lower_is_better: bool = True
    ranked: bool = True
    """Whether a value shown to be the best is bold."""

    @property
    def kind(self) -> str:
        """``reached`` or ``dots`` for columns made from a time, such as ``t99_dots``; empty for a metric."""
        time, _, kind = self.key.partition("_")
        return kind if time in LEVELS and kind in ("reached", "dots") else ""

    @property
    def of_time(self) -> bool:
        """Whether the column is a time to a threshold, or made from one."""
        return self.key.partition("_")[0] in LEVELS

    @property
    def metric(self) -> str:
        """The metric that the column is about."""
        return self.key.removesuffix(f"_{self.kind}") if self.kind else self.key

    @property
    def term(self) -> str:
        """The key of the definition that explains the column."""
        return "reached" if self.kind == "reached" else self.metric


#: The columns after the times.
OTHERS = (
    MeasureColumn("AUC", key="auc", lower_is_better=False),
    MeasureColumn("path length", "cells", "path_length"),
    MeasureColumn("overlap", key="overlap"),
    MeasureColumn("collisions", key="collisions"),
    MeasureColumn("idle", "steps", "longest_idle", ranked=False),
    MeasureColumn("oscillation", "steps", "longest_dither", ranked=False),
    MeasureColumn("failed episodes", key="failures", ranked=False),
    MeasureColumn("messages", "kB", "messages_bytes"),
    MeasureColumn("decision p50", "ms", "latency_p50_us"),
    MeasureColumn("decision p99", "ms", "latency_p99_us"),
)
#: Divisors from the stored unit to that of the table.
DIVISOR = {"messages_bytes": 1000.0, "latency_p50_us": 1000.0, "latency_p99_us": 1000.0}
#: Decimals of columns with a fixed number of them.
DECIMALS = {"auc": 3, "overlap": 2, "collisions": 2}
WITH_INTERVAL = (*LEVELS, "auc", "path_length")


def columns_of(level: CoverageThreshold) -> tuple[MeasureColumn, ...]:
    """Return the columns of a scenario with this threshold; thresholds above it only have a time, which is a dash."""
    times = (column for key in tabled([level]) for column in _time_columns(CoverageThreshold(key), key in level.times))
    return (*times, MeasureColumn(f"{level.title} by episode", "steps", f"{level.key}_dots", ranked=False), *OTHERS)


def _time_columns(level: CoverageThreshold, asked: bool) -> list[MeasureColumn]:
    time = MeasureColumn(level.title, "steps", level.key)
    reached = MeasureColumn(f"reached {percent(level.share)}", key=f"{level.key}_reached", ranked=False)
    return [time, reached] if asked else [time]


def results_table(comparison: Comparison, styles: Styles) -> list[Row]:
    """Return the cells of each policy, in the order of :func:`columns_of`; rows in the experiment's order."""
    columns = [_column(comparison, column, styles) for column in columns_of(comparison.level)]
    return [Row(policy, [cells[policy] for cells in columns]) for policy in comparison.groups]


def _column(comparison: Comparison, column: MeasureColumn, styles: Styles) -> dict[str, Cell]:
    special: dict[str, Callable[[Comparison], dict[str, Cell]]] = {
        "reached": partial(_reached, metric=column.metric),
        "dots": partial(_dot_plots, metric=column.metric, styles=styles),
        "failures": _failures,
        **{metric: partial(_wasted, metric=metric) for metric in WASTED},
    }
    make = special.get(column.kind or column.key, partial(_measured, metric=column.key))
    cells = make(comparison)
    return emphasised(comparison, column, cells) if column.ranked else cells


def _measured(comparison: Comparison, metric: str) -> dict[str, Cell]:
    estimates = {policy: comparison.estimate(policy, metric) for policy in comparison.groups}
    largest = max((each.mean for each in estimates.values() if not math.isnan(each.mean)), default=0.0)
    divisor = DIVISOR.get(metric, 1.0)
    usual = decimals_for(largest / divisor, most=1 if metric in LEVELS else 2)
    decimals = DECIMALS.get(metric, usual) if largest else 0
    return {policy: _figure(each, metric, divisor, decimals) for policy, each in estimates.items()}


def _figure(estimate: Estimate, metric: str, divisor: float, decimals: int) -> Cell:
    mean = estimate.mean / divisor
    if math.isnan(mean):
        return Cell(fixed(None, 0))
    digits = max(decimals, _needed(mean)) if divisor != 1.0 else decimals
    return Cell(fixed(mean, digits), estimate.mean, interval(estimate, decimals) if metric in WITH_INTERVAL else "")


def _needed(value: float) -> int:
    """Return the number of decimals for two significant digits, at most three."""
    return 0 if value >= 10 or value == 0 else min(3, 1 - math.floor(math.log10(value)))


def _reached(comparison: Comparison, metric: str) -> dict[str, Cell]:
    cells = {}
    for policy, records in comparison.groups.items():
        share = comparison.results.success(comparison.scenario, policy, metric)
        detail = f"{round(share.mean * len(records))}/{len(records)} {percent_interval(share)}".strip()
        cells[policy] = Cell(percent(share.mean), share.mean, detail)
    return cells


def _dot_plots(comparison: Comparison, metric: str, styles: Styles) -> dict[str, Cell]:
    values = {policy: comparison.results.values(comparison.scenario, policy, metric) for policy in comparison.groups}
    far = far_behind(comparison)
    scale = Scale(0.0, max(float(each.max()) for policy, each in values.items() if policy not in far), 110)
    return {
        policy: Cell("", None, episode_dot_plot(each, comparison.estimate(policy, metric), scale, styles[policy]))
        for policy, each in values.items()
    }


def _wasted(comparison: Comparison, metric: str) -> dict[str, Cell]:
    """Return the mean over episodes and the maximum; marked as bad if that is more than :func:`tolerated_steps`."""
    cells = {}
    for policy, records in comparison.groups.items():
        values = comparison.results.values(comparison.scenario, policy, metric)
        measured = values[~np.isnan(values)]
        most, mean = (float(measured.max()), float(measured.mean())) if len(measured) else (0.0, math.nan)
        detail = f"≤ {fixed(most, 0)}" if len(measured) else ""
        bad = most > tolerated_steps(metric, records[0].team)
        cells[policy] = Cell(fixed(mean, 1), None if math.isnan(mean) else mean, detail, bad=bad)
    return cells


def _failures(comparison: Comparison) -> dict[str, Cell]:
    counts = {policy: len(failed(records)) for policy, records in comparison.groups.items()}
    return {policy: Cell(str(count), float(count), bad=count > 0) for policy, count in counts.items()}


def emphasised(comparison: Comparison, column: MeasureColumn, cells: dict[str, Cell]) -> dict[str, Cell]:
    """Mark the cells that are shown to be the best; mostly there is none."""
    winners = shown_best(comparison, column.key, lower_is_better=column.lower_is_better)
    return {policy: replace(cell, best=policy in winners) for policy, cell in cells.items()}


def constant_columns(columns: Sequence[MeasureColumn], rows: Sequence[Row]) -> list[tuple[MeasureColumn, Cell]]:
    """Return the columns whose figure is the same in every row, and that figure; the page lists them below the table.

    A single row has none. Times, drawings and bad figures always stay in the table.
    """
    if len(rows) < 2:
        return []
    shown = [(column, [row.cells[place] for row in rows]) for place, column in enumerate(columns)]
    return [(column, cells[0]) for column, cells in shown if _may_be_left_out(column) and _same(cells)]


def _may_be_left_out(column: MeasureColumn) -> bool:
    return column.kind != "dots" and (column.kind == "reached" or not column.of_time)


def _same(cells: Sequence[Cell]) -> bool:
    first = cells[0]
    return not first.bad and all((each.text, each.value) == (first.text, first.value) for each in cells)


#: Decimals of the measures that are ratios.
RATIO_DECIMALS = {"t99_to_bound": 2, "t99_to_reference": 2}
#: Measures that are only about teams.
OF_TEAMS = {"auc_worst", "t99_worst", "auc_mean", "path_max", "balance", "blocked"}
#: One measure, and the cell of each policy.
MeasureRow = tuple[MeasureColumn, list[Cell]]


def measures_table(comparison: Comparison) -> list[MeasureRow]:
    """Return the measures that the results table leaves out and that have a value, then pilot statistics."""
    return [row for row in _measure_rows(comparison) if any(cell.value is not None for cell in row[1])]


def _measure_rows(comparison: Comparison) -> Iterator[MeasureRow]:
    alone = all(record.team == 1 for record in comparison.records)
    left_out = {column.key for column in columns_of(comparison.level)} | (OF_TEAMS if alone else set())
    for key, measure in comparison.results.measures.items():
        if key not in left_out:
            column = MeasureColumn(measure.title, measure.unit, key, lower_is_better=measure.lower_is_better)
            yield column, _measure_cells(comparison, column)
    for key in comparison.tallies:
        column = MeasureColumn(key.removeprefix("pilot_").replace("_", " "), "pilot statistic", key, ranked=False)
        yield column, _measure_cells(comparison, column)


def _measure_cells(comparison: Comparison, column: MeasureColumn) -> list[Cell]:
    estimates = {policy: comparison.estimate(policy, column.key) for policy in comparison.groups}
    largest = max((abs(each.mean) for each in estimates.values() if not math.isnan(each.mean)), default=0.0)
    usual = 3 if largest < 1 or not column.ranked else decimals_for(largest, most=2)
    decimals = RATIO_DECIMALS.get(column.key, usual) if largest else 0
    cells = {policy: _measure_cell(each, decimals) for policy, each in estimates.items()}
    if column.key in RATIO_DECIMALS:
        cells = {policy: _bounded(comparison, policy, cell) for policy, cell in cells.items()}
    return list((emphasised(comparison, column, cells) if column.ranked else cells).values())


def _bounded(comparison: Comparison, policy: str, cell: Cell) -> Cell:
    """Mark a ratio as a lower bound where some episodes never reached the threshold and count as the budget."""
    if cell.value is None or comparison.results.success(comparison.scenario, policy, "t99").mean == 1:
        return cell
    return replace(cell, text=f"> {cell.text}", detail="")


def _measure_cell(estimate: Estimate, decimals: int) -> Cell:
    if math.isnan(estimate.mean):
        return Cell(fixed(None, 0))
    return Cell(fixed(estimate.mean, decimals), estimate.mean, interval(estimate, decimals) if decimals else "")
