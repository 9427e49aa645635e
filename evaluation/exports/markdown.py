"""The results as Markdown tables: one for each scenario, and ratios of steps for each baseline and time."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from indoor_explorers.evaluation.analysis.best_planner import PlannerRow
from indoor_explorers.evaluation.analysis.tables.origin_table import origin_tables
from indoor_explorers.evaluation.analysis.tables.planner_table import planner_table
from indoor_explorers.evaluation.analysis.tables.policy_names import footnotes, marked
from indoor_explorers.evaluation.analysis.tables.ratio_table import bound_notes, ratio_tables
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row, Table
from indoor_explorers.evaluation.harness.results.origin_ratios import ratios_by_origin
from indoor_explorers.evaluation.harness.results.ratios import Ratios

#: Characters with a meaning in Markdown, and in GitHub's tables and mathematics.
SPECIAL = re.compile(r"([\\`*_\[\]>|~$#])")


def markdown_tables(tables: Sequence[Table]) -> str:
    """Return a heading, a table and its notes for each of the tables."""
    return "\n".join(_section(table, _figure) for table in tables)


def _section(table: Table, figure: Callable[[Cell], str]) -> str:
    titles = [column.title for column in table.columns]
    rows = [[escaped(name), *map(figure, cells)] for name, cells, _ in table.rows]
    notes = [escaped(" ".join(table.notes)), ""] if table.notes else []
    aligned = ["---", *["---:"] * (len(titles) - 1)]
    return "\n".join([f"## {escaped(table.title)}", "", *map(line, [titles, aligned, *rows]), "", *notes])


def line(cells: Iterable[str]) -> str:
    """Return a line of a table."""
    return f"| {' | '.join(cells)} |"


def _figure(cell: Cell) -> str:
    text = SPECIAL.sub(r"\\\1", cell.text)
    return replace(cell, text=f"**{text}**" if cell.best else text).line


def escaped(text: str) -> str:
    """Return text that Markdown shows as it is, on one line.

    What begins a tag or an entity becomes an entity, since not every reader of Markdown takes a backslash before it.
    """
    return SPECIAL.sub(r"\\\1", " ".join(text.split())).replace("&", "&amp;").replace("<", "&lt;")


def markdown_ratios(ratios: Ratios, best_planner: Sequence[PlannerRow] = ()) -> str:
    """Return a heading and a table of policies by scenarios for each baseline and time, and of the best planners."""
    tables, results = ratio_tables(ratios), ratios.results
    notes = [*bound_notes(ratios.rows), *footnotes(results, [row.name for t in tables for row in t.rows], times=False)]
    shown = [
        replace(
            table,
            columns=[Column(escaped(results.title(column.title))) for column in table.columns],
            rows=[Row(marked(results, name), cells) for name, cells, _ in table.rows],
            notes=(),
        )
        for table in tables
    ]
    by_policy = filter(None, [*origin_tables(ratios_by_origin(ratios)), planner_table(best_planner)])
    shown += [
        replace(table, columns=[Column(escaped(marked(results, each.title))) for each in table.columns])
        for table in by_policy
    ]
    return "\n".join(
        [*(_section(table, lambda cell: cell.line) for table in shown), *(f"{escaped(note)}\n" for note in notes)]
    )
