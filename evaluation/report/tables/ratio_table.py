"""Steps as a ratio to another policy's: policies by scenarios, for the page, for Markdown and for a terminal."""

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
#: How far from 1, as a power of 2, ratios get the next shade; four shades each way.
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
    """From -4, many more steps, to 4, much fewer; 0 where the interval holds 1 or there is none."""


@dataclass(frozen=True)
class RatioTable:
    """One level against one policy."""

    to: str
    metric: str
    scenarios: list[tuple[str, str]]
    """Names of the columns with the tasks they are about; all together last where there are several."""
    rows: list[tuple[str, list[RatioCell | None]]]
    """By policy; a cell a scenario, None where it was not flown."""

    @property
    def title(self) -> str:
        """What is divided by what."""
        return f"{MEASURES[self.metric].title} as a ratio to {self.to}"


def ratio_tables(ratios: Ratios) -> list[RatioTable]:
    """Return a table for each baseline and level, highest first; empty when no two policies can be compared."""
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
    """Yield what a terminal shows: a table for each baseline, a line for each scenario and policy."""
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
