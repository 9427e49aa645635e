"""Columns of a table that are the same for all policies, which the page names below it instead of showing them."""

from __future__ import annotations

from collections.abc import Sequence

from indoor_explorers.evaluation.analysis.tables.results_table import MeasureColumn
from indoor_explorers.evaluation.drawing.table import Cell, Row


def constant_columns(columns: Sequence[MeasureColumn], rows: Sequence[Row]) -> list[tuple[MeasureColumn, Cell]]:
    """Return the columns with the same figure in every row, with that figure; none for a single row.

    Times and drawings are always shown, as is a figure that is shown to be bad.
    """
    if len(rows) < 2:
        return []
    shown = [(column, [row.cells[place] for row in rows]) for place, column in enumerate(columns)]
    return [(column, cells[0]) for column, cells in shown if _may_go(column) and _same(cells)]


def _may_go(column: MeasureColumn) -> bool:
    return column.kind != "dots" and (column.kind == "reached" or not column.of_time)


def _same(cells: Sequence[Cell]) -> bool:
    first = cells[0]
    return not first.bad and all((each.text, each.value) == (first.text, first.value) for each in cells)
