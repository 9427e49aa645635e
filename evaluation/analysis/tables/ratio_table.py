"""Tables of steps as ratios to a baseline's, policies by scenarios, for the page, Markdown and the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from rich.console import RenderableType
from rich.text import Text

from indoor_explorers.evaluation.analysis.tables.policy_names import footnotes, marked
from indoor_explorers.evaluation.drawing.formatting import counted, fixed, interval, percent, with_interval
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row, Table, terminal_table, words
from indoor_explorers.evaluation.harness.episodes.metrics import MEASURES
from indoor_explorers.evaluation.harness.results.ratios import LEAST_REACHED, POOLED, RatioRow, Ratios

#: Decimals of a ratio.
DECIMALS = 3
#: Width of a shade as a power of 2 of the ratio; there are four shades on each side of 1.
SHADE = 0.15


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


def ratio_tables(ratios: Ratios) -> list[Table]:
    """Return a table for each baseline and time, highest threshold first; empty if no two policies can be compared.

    Its columns are scenarios, with their numbers of tasks for units, and all of them together last if there are
    several. A cell is shaded from -4 for many more steps to 4 for many fewer; its title is the ratio of the means.
    """
    tables = [_table(ratios, to, metric) for to in ratios.to for metric in reversed(ratios.metrics)]
    return [table for table in tables if table.rows]


def _table(ratios: Ratios, to: str, metric: str) -> Table:
    rows = [row for row in ratios.rows if (row.to, row.metric) == (to, metric)]
    cells = {(row.policy, row.scenario): ratio_cell(row, len(_scenarios(rows))) for row in rows}
    tasks = {row.scenario: counted(row.tasks, "task") for row in sorted(rows, key=lambda row: row.tasks)}
    columns = [Column(name, tasks[name]) for name in _pooled_last(rows)]
    policies = dict.fromkeys(name for name in ratios.results.policies for row in rows if row.policy == name)
    return Table(
        [Column("policy"), *columns],
        [Row(name, [cells.get((name, column.title), Cell()) for column in columns]) for name in policies],
        f"{MEASURES[metric].title} as a ratio to {to}",
        f"{metric}_to_{to}",
        [f"Steps divided by those of {to}; below 1 is faster."],
    )


def ratio_cell(row: RatioRow, scenarios: int = 1, decimals: int = DECIMALS) -> Cell:
    """Return the cell of a ratio; one over all scenarios says over how many of them if it is not over all."""
    mean, low, high = of_tasks = row.ratio.of_tasks
    bound = row.censoring.bound
    shown = low is not None and high is not None and not low <= 1.0 <= high and bound != ("<" if mean > 1 else ">")
    shade = min(4, math.ceil(abs(math.log2(mean)) / SHADE)) if shown else 0
    around = "" if bound in (">", "<") else interval(of_tasks, decimals)
    partly = row.scenario == POOLED and row.scenarios < scenarios
    part = f" {row.scenarios} of {scenarios} scenarios" if partly else ""
    text, means = (bounded(fixed(each.mean, decimals), bound) for each in row.ratio)
    means = means if bound in (">", "<") else with_interval(row.ratio.of_means, decimals)
    return Cell(
        text,
        None if math.isnan(mean) else mean,
        (around + part).strip(),
        shade=shade if mean < 1 else -shade,
        title=f"ratio of the means: {means}",
    )


def ratio_lines(ratios: Ratios) -> Iterator[RenderableType]:
    """Yield the parts of the terminal's output: a table for each baseline, with a line for each scenario and policy."""
    for to in ratios.to:
        rows = [row for row in ratios.rows if row.to == to]
        if rows:
            yield terminal_table(_by_scenario(to, ratios, rows))
    yield Text(
        "mean over tasks of the ratio [95 % interval], and the ratio of the means, where long tasks count more",
        "dim",
    )
    for note in [*bound_notes(ratios.rows), *footnotes(ratios.results, [r.policy for r in ratios.rows], times=False)]:
        yield Text(note, "dim")


def _by_scenario(to: str, ratios: Ratios, rows: list[RatioRow]) -> Table:
    columns, table, scenarios = [words(f"steps relative to {to}", 24)], [], len(_scenarios(rows))
    for metric in ratios.metrics:
        columns += [Column(MEASURES[metric].title), Column("ratio of\nthe means", style="dim")]
    for scenario in _pooled_last(rows):
        table.append(Row(scenario))
        for policy in dict.fromkeys(row.policy for row in rows):
            found = {row.metric: row for row in rows if (row.scenario, row.policy) == (scenario, policy)}
            if found:
                pairs = (
                    _pair(each, scenarios) if each else (Cell(), Cell()) for each in map(found.get, ratios.metrics)
                )
                table.append(Row(marked(ratios.results, policy), [cell for pair in pairs for cell in pair]))
    return Table(columns, table)


def _pair(row: RatioRow, scenarios: int) -> tuple[Cell, Cell]:
    """Return the mean of ratios with its interval, and the ratio of the means."""
    means = bounded(fixed(row.ratio.of_means.mean, DECIMALS), row.censoring.bound)
    return ratio_cell(row, scenarios), Cell(means)


def _scenarios(rows: Sequence[RatioRow]) -> list[str]:
    return list(dict.fromkeys(row.scenario for row in rows if row.scenario != POOLED))


def _pooled_last(rows: Sequence[RatioRow]) -> list[str]:
    return _scenarios(rows) + [POOLED] * any(row.scenario == POOLED for row in rows)
