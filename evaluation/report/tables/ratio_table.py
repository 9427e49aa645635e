"""Tables of steps as ratios to a baseline's, policies by scenarios, for the page, Markdown and the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from rich import box
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from indoor_explorers.evaluation.episodes.metrics import MEASURES
from indoor_explorers.evaluation.report.style.formatting import counted, fixed, interval, with_interval
from indoor_explorers.evaluation.report.tables.policy_names import footnotes, marked
from indoor_explorers.evaluation.results.ratios import POOLED, RatioRow, Ratios

#: Decimals of a ratio.
DECIMALS = 3
#: Width of a shade as a power of 2 of the ratio; there are four shades on each side of 1.
SHADE = 0.15


@dataclass(frozen=True)
class RatioCell:
    """One policy on one scenario."""

    value: float
    text: str
    """Mean over tasks of the ratio."""
    interval: str
    of_means: str
    """Ratio of the means with its interval."""
    shade: int
    """From -4 for many more steps to 4 for many fewer; 0 if the interval contains 1 or there is none."""


@dataclass(frozen=True)
class RatioTable:
    """The ratios of one time to one baseline."""

    to: str
    metric: str
    scenarios: list[tuple[str, str]]
    """Names of the columns with their number of tasks; all scenarios together last if there are several."""
    rows: list[tuple[str, list[RatioCell | None]]]
    """By policy; a cell for each scenario, None where it was not flown."""

    @property
    def title(self) -> str:
        """The heading of the table."""
        return f"{MEASURES[self.metric].title} as a ratio to {self.to}"


def ratio_tables(ratios: Ratios) -> list[RatioTable]:
    """Return a table for each baseline and time, highest threshold first; empty if no two policies can be compared."""
    tables = [_table(ratios, to, metric) for to in ratios.to for metric in reversed(ratios.metrics)]
    return [table for table in tables if table.rows]


def _table(ratios: Ratios, to: str, metric: str) -> RatioTable:
    rows = [row for row in ratios.rows if (row.to, row.metric) == (to, metric)]
    cells = {(row.policy, row.scenario): _cell(row) for row in rows}
    scenarios = {row.scenario: counted(row.tasks, "task") for row in rows}
    policies = dict.fromkeys(name for name in ratios.results.policies for row in rows if row.policy == name)
    table = [(name, [cells.get((name, scenario)) for scenario in scenarios]) for name in policies]
    return RatioTable(to, metric, list(scenarios.items()), table)


def _cell(row: RatioRow) -> RatioCell:
    mean, low, high = of_tasks = row.ratio.of_tasks
    shown = low is not None and high is not None and not low <= 1.0 <= high
    shade = min(4, math.ceil(abs(math.log2(mean)) / SHADE)) if shown else 0
    means = with_interval(row.ratio.of_means, DECIMALS)
    return RatioCell(mean, fixed(mean, DECIMALS), interval(of_tasks, DECIMALS), means, shade if mean < 1 else -shade)


def ratio_lines(ratios: Ratios) -> Iterator[RenderableType]:
    """Yield the parts of the terminal's output: a table for each baseline, with a line for each scenario and policy."""
    for to in ratios.to:
        rows = [row for row in ratios.rows if row.to == to]
        if rows:
            yield _printed(to, ratios, rows)
    yield Text("mean over tasks of the ratio [95 % interval], and the ratio of the means", "dim")
    for note in footnotes(ratios.results, [row.policy for row in ratios.rows], times=False):
        yield Text(note, "dim")


def _printed(to: str, ratios: Ratios, rows: list[RatioRow]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column(f"steps / {to}'s", overflow="fold", min_width=24)
    for metric in ratios.metrics:
        table.add_column(MEASURES[metric].title, justify="right", no_wrap=True)
        table.add_column("of means", justify="right", no_wrap=True, style="dim")
    for scenario in _pooled_last(rows):
        table.add_row(Text(scenario, "bold"))
        for policy in dict.fromkeys(row.policy for row in rows):
            found = {row.metric: row.ratio for row in rows if (row.scenario, row.policy) == (scenario, policy)}
            if found:
                pairs = (
                    (with_interval(each.of_tasks, DECIMALS), fixed(each.of_means.mean, DECIMALS)) if each else ("", "")
                    for each in map(found.get, ratios.metrics)
                )
                table.add_row(Text(marked(ratios.results, policy)), *(cell for pair in pairs for cell in pair))
    return table


def _pooled_last(rows: list[RatioRow]) -> list[str]:
    names = list(dict.fromkeys(row.scenario for row in rows))
    return sorted(names, key=lambda name: name == POOLED)
