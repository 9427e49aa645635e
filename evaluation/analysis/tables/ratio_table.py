"""Tables of steps as ratios to a baseline's, policies by scenarios, for the page, Markdown and the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rich import box
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from indoor_explorers.evaluation.analysis.tables.policy_names import footnotes, marked
from indoor_explorers.evaluation.drawing.formatting import counted, fixed, interval, percent, with_interval
from indoor_explorers.evaluation.harness.episodes.metrics import MEASURES
from indoor_explorers.evaluation.harness.results.ratios import LEAST_REACHED, POOLED, RatioRow, Ratios

#: Decimals of a ratio.
DECIMALS = 3
#: Width of a shade as a power of 2 of the ratio; there are four shades on each side of 1.
SHADE = 0.15


@dataclass(frozen=True)
class RatioCell:
    """One policy on one scenario."""

    value: float | None
    text: str
    """Mean over tasks of the ratio, marked where it is a bound; a dash where there is none."""
    interval: str
    """Empty for a bound; for all scenarios, how many of them entered where not all did."""
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


def bounded(text: str, bound: str | None) -> str:
    """Put the sign of a bound before a figure."""
    return f"{bound} {text}" if bound else text


def bound_notes(rows: Sequence[RatioRow]) -> list[str]:
    """Return the sentences that explain the signs of these rows; empty where every threshold was reached."""
    if not any(any(row.censoring[1:]) for row in rows):
        return []
    least = percent(LEAST_REACHED)
    return [
        "> and <: bounds, as some episodes of one of the two never reached the threshold and count as the budget; "
        f"\N{ALMOST EQUAL TO}: of both, in less than {percent(1 - LEAST_REACHED)} of the tasks; a dash: in more.",
        *(
            [f"Averages over scenarios leave out those in which not both reached it in {least} of the tasks."]
            if any(not row.censoring.mostly_reached for row in rows)
            else []
        ),
    ]


def ratio_tables(ratios: Ratios) -> list[RatioTable]:
    """Return a table for each baseline and time, highest threshold first; empty if no two policies can be compared."""
    tables = [_table(ratios, to, metric) for to in ratios.to for metric in reversed(ratios.metrics)]
    return [table for table in tables if table.rows]


def _table(ratios: Ratios, to: str, metric: str) -> RatioTable:
    rows = [row for row in ratios.rows if (row.to, row.metric) == (to, metric)]
    cells = {(row.policy, row.scenario): _cell(row, len(_scenarios(rows))) for row in rows}
    scenarios = {row.scenario: counted(row.tasks, "task") for row in sorted(rows, key=lambda row: row.tasks)}
    scenarios = {name: scenarios[name] for name in _pooled_last(rows)}
    policies = dict.fromkeys(name for name in ratios.results.policies for row in rows if row.policy == name)
    table = [(name, [cells.get((name, scenario)) for scenario in scenarios]) for name in policies]
    return RatioTable(to, metric, list(scenarios.items()), table)


def _cell(row: RatioRow, scenarios: int) -> RatioCell:
    mean, low, high = of_tasks = row.ratio.of_tasks
    bound = row.censoring.bound
    shown = low is not None and high is not None and not low <= 1.0 <= high and bound != ("<" if mean > 1 else ">")
    shade = min(4, math.ceil(abs(math.log2(mean)) / SHADE)) if shown else 0
    around = "" if bound in (">", "<") else interval(of_tasks, DECIMALS)
    partly = row.scenario == POOLED and row.scenarios < scenarios
    part = f" {row.scenarios} of {scenarios} scenarios" if partly else ""
    text, means = (bounded(fixed(each.mean, DECIMALS), bound) for each in row.ratio)
    means = means if bound in (">", "<") else with_interval(row.ratio.of_means, DECIMALS)
    return RatioCell(
        None if math.isnan(mean) else mean, text, (around + part).strip(), means, shade if mean < 1 else -shade
    )


def ratio_lines(ratios: Ratios) -> Iterator[RenderableType]:
    """Yield the parts of the terminal's output: a table for each baseline, with a line for each scenario and policy."""
    for to in ratios.to:
        rows = [row for row in ratios.rows if row.to == to]
        if rows:
            yield _printed(to, ratios, rows)
    yield Text(
        "mean over tasks of the ratio [95 % interval], and the ratio of the means, where long tasks count more",
        "dim",
    )
    for note in [*bound_notes(ratios.rows), *footnotes(ratios.results, [r.policy for r in ratios.rows], times=False)]:
        yield Text(note, "dim")


def _printed(to: str, ratios: Ratios, rows: list[RatioRow]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column(f"steps relative to {to}", overflow="fold", min_width=24)
    for metric in ratios.metrics:
        table.add_column(MEASURES[metric].title, justify="right", no_wrap=True)
        table.add_column("ratio of\nthe means", justify="right", no_wrap=True, style="dim")
    scenarios = len(_scenarios(rows))
    for scenario in _pooled_last(rows):
        table.add_row(Text(scenario, "bold"))
        for policy in dict.fromkeys(row.policy for row in rows):
            found = {row.metric: row for row in rows if (row.scenario, row.policy) == (scenario, policy)}
            if found:
                pairs = (_figures(each, scenarios) if each else ("", "") for each in map(found.get, ratios.metrics))
                table.add_row(Text(marked(ratios.results, policy)), *(cell for pair in pairs for cell in pair))
    return table


def _figures(row: RatioRow, scenarios: int) -> tuple[str, str]:
    """Return the mean of ratios with its interval, and the ratio of the means."""
    cell, bound = _cell(row, scenarios), row.censoring.bound
    return f"{cell.text} {cell.interval}".strip(), bounded(fixed(row.ratio.of_means.mean, DECIMALS), bound)


def _scenarios(rows: Sequence[RatioRow]) -> list[str]:
    return list(dict.fromkeys(row.scenario for row in rows if row.scenario != POOLED))


def _pooled_last(rows: Sequence[RatioRow]) -> list[str]:
    return _scenarios(rows) + [POOLED] * any(row.scenario == POOLED for row in rows)
