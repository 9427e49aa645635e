"""The terminal's table of what changed."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

from rich.console import RenderableType
from rich.text import Text

from indoor_explorers.evaluation.analysis.changes.against import Against, Change
from indoor_explorers.evaluation.drawing.formatting import counted
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row, Table, terminal_table, words

#: Width in characters from which old and new means are shown beside their difference.
WIDE = 110


def against_lines(against: Against, width: int = WIDE) -> Iterator[RenderableType]:
    """Yield the parts of the terminal's output: a table, significant changes first, and what could not be compared."""
    if against.changes:
        yield terminal_table(_table(against, width >= WIDE))
    yield Text(f"{against.shown} of {counted(len(against.changes), 'comparison')} changed significantly")
    for each in against.identities:
        yield Text(f"{each.scenario}, {each.policy}: {each.text}")
    for line in against.apart:
        yield Text(line, "yellow")


def _table(against: Against, wide: bool) -> Table:
    headings = ("old", "new", "new - old", "detectable") if wide else ("new - old",)
    rows, several = list[Row](), len({change.scenario for change in against.changes}) > 1
    for scenario, changes in groupby(against.changes, lambda change: change.scenario):
        rows += [Row(scenario)] if several else []
        for change in changes:
            figures = map(Cell, (change.title, *(change.figures if wide else change.figures[2:3])))
            rows.append(Row(change.policy, [*figures, Cell(change.verdict, style=_style(change))]))
    return Table([words("policy", 14), Column("figure", left=True), *map(Column, headings), words("")], rows)


def _style(change: Change) -> str:
    if not change.shown:
        return "dim"
    return "bold green" if change.better else "bold red"
