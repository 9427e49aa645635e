"""The results as Markdown tables: one for each scenario, and ratios of steps for each baseline and time."""

from __future__ import annotations

import re
from collections.abc import Sequence

from indoor_explorers.evaluation.analysis.comparability import missing_episodes
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.tables.policy_names import footnotes, marked
from indoor_explorers.evaluation.analysis.tables.ratio_table import RatioTable, bound_notes, ratio_tables
from indoor_explorers.evaluation.exports.cells import ExportCell, caption, table_headings, table_rows
from indoor_explorers.evaluation.harness.results.ratios import Ratios
from indoor_explorers.evaluation.harness.results.results import Results

#: Characters with a meaning in Markdown, and in GitHub's tables and mathematics.
SPECIAL = re.compile(r"([\\`*_\[\]>|~$#])")


def markdown_tables(results: Results) -> str:
    """Return a heading, a table and its caption for each scenario that was flown."""
    comparisons = [Comparison(results.on_common_tasks, scenario) for scenario in results.scenarios]
    missing = {scenario: missing_episodes(results, scenario) for scenario in results.scenarios}
    return "\n".join(_section(each, missing[each.scenario]) for each in comparisons if each.groups)


def _section(comparison: Comparison, missing: Sequence[str]) -> str:
    shown = table_headings(comparison)
    lines = [
        f"## {escaped(comparison.title)}",
        "",
        _line(["policy", *shown]),
        _line(["---", *["---:"] * len(shown)]),
        *(_line([escaped(row.policy), *map(_figure, row.cells)]) for row in table_rows(comparison)),
        "",
        escaped(" ".join([*caption(comparison), *missing])),
        "",
    ]
    return "\n".join(lines)


def _line(cells: list[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _figure(cell: ExportCell) -> str:
    text = SPECIAL.sub(r"\\\1", cell.text)
    text = f"**{text}**" if cell.best else text
    return f"{text} {cell.interval}".strip()


def escaped(text: str) -> str:
    """Return text that Markdown shows as it is, on one line.

    What begins a tag or an entity becomes an entity, since not every reader of Markdown takes a backslash before it.
    """
    return SPECIAL.sub(r"\\\1", " ".join(text.split())).replace("&", "&amp;").replace("<", "&lt;")


def markdown_ratios(ratios: Ratios) -> str:
    """Return a heading and a table of policies by scenarios for each baseline and time."""
    tables = ratio_tables(ratios)
    policies = [name for table in tables for name, _ in table.rows]
    notes = [*bound_notes(ratios.rows), *footnotes(ratios.results, policies, times=False)]
    return "\n".join([*(_ratios(table, ratios.results) for table in tables), *(f"{escaped(note)}\n" for note in notes)])


def _ratios(table: RatioTable, results: Results) -> str:
    names = [escaped(results.title(name)) for name, _ in table.scenarios]
    rows = [
        [escaped(marked(results, policy)), *(f"{c.text} {c.interval}".strip() if c else "" for c in cells)]
        for policy, cells in table.rows
    ]
    lines = [f"## {escaped(table.title)}", "", _line(["policy", *names]), _line(["---", *["---:"] * len(names)])]
    return "\n".join([*lines, *map(_line, rows), ""])
