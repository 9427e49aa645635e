"""The table of the measures that the results table leaves out: a row for each, a column for each policy."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.tables.results_table import MeasureColumn, columns_of, emphasised
from indoor_explorers.evaluation.drawing.formatting import decimals_for, fixed, interval
from indoor_explorers.evaluation.drawing.table import Cell
from indoor_explorers.evaluation.statistics import Estimate

#: Decimals of ratios.
DECIMALS = {"t99_to_bound": 2, "t99_to_reference": 2}
#: Measures that are only about teams.
OF_TEAMS = {"auc_worst", "t99_worst", "auc_mean", "path_max", "balance", "blocked"}
#: One measure, and the cell of each policy.
MeasureRow = tuple[MeasureColumn, list[Cell]]


def measures_table(comparison: Comparison) -> list[MeasureRow]:
    """Return the measures that the results table leaves out and that have a value, then pilot statistics."""
    return [row for row in _rows(comparison) if any(cell.value is not None for cell in row[1])]


def _rows(comparison: Comparison) -> Iterator[MeasureRow]:
    alone = all(record.team == 1 for record in comparison.records)
    left_out = {column.key for column in columns_of(comparison.level)} | (OF_TEAMS if alone else set())
    for key, measure in comparison.results.measures.items():
        if key not in left_out:
            column = MeasureColumn(measure.title, measure.unit, key, lower_is_better=measure.lower_is_better)
            yield column, _cells(comparison, column)
    for key in comparison.tallies:
        column = MeasureColumn(key.removeprefix("pilot_").replace("_", " "), "pilot statistic", key, ranked=False)
        yield column, _cells(comparison, column)


def _cells(comparison: Comparison, column: MeasureColumn) -> list[Cell]:
    estimates = {policy: comparison.estimate(policy, column.key) for policy in comparison.groups}
    largest = max((abs(each.mean) for each in estimates.values() if not math.isnan(each.mean)), default=0.0)
    usual = 3 if largest < 1 or not column.ranked else decimals_for(largest, most=2)
    decimals = DECIMALS.get(column.key, usual) if largest else 0
    cells = {policy: _cell(each, decimals) for policy, each in estimates.items()}
    if column.key in DECIMALS:
        cells = {policy: _bounded(comparison, policy, cell) for policy, cell in cells.items()}
    return list((emphasised(comparison, column, cells) if column.ranked else cells).values())


def _bounded(comparison: Comparison, policy: str, cell: Cell) -> Cell:
    """Mark a ratio as a lower bound where some episodes never reached the threshold and count as the budget."""
    if cell.value is None or comparison.results.success(comparison.scenario, policy, "t99").mean == 1:
        return cell
    return replace(cell, text=f"> {cell.text}", detail="")


def _cell(estimate: Estimate, decimals: int) -> Cell:
    if math.isnan(estimate.mean):
        return Cell(fixed(None, 0))
    return Cell(fixed(estimate.mean, decimals), estimate.mean, interval(estimate, decimals) if decimals else "")
