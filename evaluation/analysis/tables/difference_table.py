"""The terminal's tables of steps minus a baseline's, policies by scenarios."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich import box
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from indoor_explorers.evaluation.analysis.tables.policy_names import marked
from indoor_explorers.evaluation.drawing.formatting import with_interval
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
        yield _printed(results, minus, [row for row in rows if row.minus == minus])
    if rows:
        yield Text(
            f"mean paired difference in steps [95 % interval] over the tasks that both finished; {SIGNIFICANT}: "
            "significant, adjusted for the policies compared with this baseline on a scenario (Holm)",
            "dim",
        )


def _printed(results: Results, minus: str, rows: Sequence[DifferenceRow]) -> Table:
    table, times = Table(box=box.SIMPLE_HEAD, pad_edge=False), drawn(results.levels)
    table.add_column(f"steps - {minus}'s", overflow="fold", min_width=24)
    for metric in times:
        table.add_column(MEASURES[metric].title, justify="right", no_wrap=True)
    for scenario in dict.fromkeys(row.scenario for row in rows):
        table.add_row(Text(scenario, "bold"))
        found = {(row.policy, row.metric): row.contrast for row in rows if row.scenario == scenario}
        for policy in dict.fromkeys(policy for policy, _ in found):
            cells = [_figure(found[policy, metric]) if (policy, metric) in found else "" for metric in times]
            table.add_row(Text(marked(results, policy)), *cells)
    return table


def _figure(contrast: Contrast) -> str:
    mark = f" {SIGNIFICANT}" if contrast.shown and contrast.difference.low is not None else "  "
    return with_interval(contrast.difference, sign=True) + mark
