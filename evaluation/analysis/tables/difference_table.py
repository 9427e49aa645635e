"""The terminal's tables of steps minus a baseline's, policies by scenarios."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.console import RenderableType
from rich.text import Text

from indoor_explorers.evaluation.analysis.tables.policy_names import marked
from indoor_explorers.evaluation.drawing.formatting import with_interval
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row, Table, terminal_table, words
from indoor_explorers.evaluation.harness.episodes.metrics import MEASURES
from indoor_explorers.evaluation.harness.results.coverage_threshold import drawn
from indoor_explorers.evaluation.harness.results.differences import DifferenceRow
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import Contrast

#: Marks a significant difference.
SIGNIFICANT = "*"


def difference_lines(results: Results, rows: Sequence[DifferenceRow]) -> Iterator[RenderableType]:
    """Yield the parts of the terminal's output: a table for each baseline, with a line for each scenario and policy."""
    for minus in dict.fromkeys(row.minus for row in rows):
        yield terminal_table(_table(results, minus, [row for row in rows if row.minus == minus]))
    if rows:
        yield Text(
            f"mean paired difference in steps [95 % interval] over the tasks that both finished; {SIGNIFICANT}: "
            "significant, adjusted for the policies compared with this baseline on a scenario (Holm)",
            "dim",
        )


def _table(results: Results, minus: str, rows: Sequence[DifferenceRow]) -> Table:
    times, table = drawn(results.levels), []
    for scenario in dict.fromkeys(row.scenario for row in rows):
        table.append(Row(scenario))
        found = {(row.policy, row.metric): _cell(row.contrast) for row in rows if row.scenario == scenario}
        for policy in dict.fromkeys(policy for policy, _ in found):
            table.append(Row(marked(results, policy), [found.get((policy, metric), Cell()) for metric in times]))
    return Table([words(f"steps - {minus}'s", 24), *(Column(MEASURES[metric].title) for metric in times)], table)


def _cell(contrast: Contrast) -> Cell:
    mark = f" {SIGNIFICANT}" if contrast.shown and contrast.difference.low is not None else "  "
    return Cell(with_interval(contrast.difference, sign=True) + mark)
