"""The terminal's table of results."""

from __future__ import annotations

from dataclasses import replace

from rich import table as terminal

from indoor_explorers.evaluation.analysis.comparability import missing_episodes
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.failures import failed_of
from indoor_explorers.evaluation.analysis.notes import scenario_notes
from indoor_explorers.evaluation.analysis.reported import reported_on
from indoor_explorers.evaluation.analysis.shown_best import BOLD
from indoor_explorers.evaluation.analysis.tables.policy_cells import (
    best_of,
    headings,
    ratio_cells,
    reference_of,
    result_cells,
    short_headings,
)
from indoor_explorers.evaluation.analysis.tables.policy_names import footnotes, marked
from indoor_explorers.evaluation.analysis.tables.reported_table import has_figure, reported_cells
from indoor_explorers.evaluation.drawing.formatting import decimals_for
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row, Table, terminal_table, words
from indoor_explorers.evaluation.harness.results.coverage_threshold import T99, shared, tabled
from indoor_explorers.evaluation.harness.results.results import Results

#: Width in characters from which all columns are shown.
WIDE = 110
#: The same with a column for the ratio to a policy that knows the map.
WIDEST = 135
#: Width of an additional time, and of the column for the ratio to the lower bound.
TIME_WIDTH, BOUND_WIDTH = 22, 22


def headline_table(results: Results, width: int = WIDE, *, notes: bool = True) -> terminal.Table:
    """Return one row per scenario and policy: T90 and T99 with interval, success; failures, AUC and latency.

    The last three are left out where lines have less than :data:`WIDE` characters. Where a policy that knows the map
    flew the same tasks, the last column is the mean ratio of steps to it. Success and ratio are about the threshold of
    the scenario, which has a column too; times above the goal of a scenario are a dash. The ratio to the lower bound,
    which is known for T99, is in front of it where there is room. Without ``notes`` nothing stands below.
    """
    known, levels = reference_of(results), results.levels
    level, times = shared(levels), tabled(levels)
    wide = (WIDEST if known else WIDE) + TIME_WIDTH * (len(times) - 2)
    shown = headings(levels) if width >= wide else short_headings(levels)
    to_bound = level == T99 and width >= wide + BOUND_WIDTH
    columns = [words("policy", min(30, max(map(len, results.policies), default=0))), *map(Column, shown)]
    columns += [Column("T99 / bound")] if to_bound else []
    columns += [Column(f"{level.title if level else 'steps'} / {known}")] if known else []
    lines = footnotes(results, [policy for _, policy in results.groups], times=width >= wide)
    lines += [BOLD] if len(results.policies) - len(results.privileged_policies) > 1 else []
    several, rows = len(results.scenarios) > 1, list[Row]()
    for scenario in results.scenarios:
        name = results.title(scenario)
        if several or name != scenario:
            rows.append(Row(name if level else f"{name} ({results.level(scenario).title})"))
        comparison = Comparison(results.on_common_tasks, scenario)
        lines += missing_episodes(results, scenario) + _notes(comparison, named=several)
        best = best_of(comparison)
        for policy in comparison.groups:
            cells = result_cells(comparison, policy, times, best, decimals_for)[: len(shown)]
            cells[len(times) :] = [replace(cell, detail="") for cell in cells[len(times) :]]
            cells += ratio_cells(comparison, policy, to_bound=to_bound, to_reference=known is not None)
            rows.append(_named(comparison, policy, cells))
        for figures in reported_on(comparison):
            cells = reported_cells(figures, times)[: len(shown)]
            cells[len(times) :] = [replace(cell, detail="") for cell in cells[len(times) :]]
            if has_figure(cells):
                rows.append(Row(figures.name, cells + [Cell()] * (len(columns) - 1 - len(cells)), "italic"))
            lines.append(figures.note)
    bounds = {cell.text[0] for row in rows for cell in row.cells if cell.text.startswith((">", "<"))}
    lines += [f"{' and '.join(sorted(bounds))}: a bound, as some episodes never reached it."] if bounds else []
    return terminal_table(Table(columns, rows, notes=lines if notes else ()), sections=True)


def _notes(comparison: Comparison, named: bool) -> list[str]:
    """Return the lines below the table about one scenario, which they name where there are several."""
    text = " ".join(scenario_notes(comparison)) if comparison.groups else ""
    return [f"{comparison.scenario}: {text}" if named else text] if text else []


def _named(comparison: Comparison, policy: str, cells: list[Cell]) -> Row:
    failures, name = failed_of(comparison, policy), marked(comparison.results, policy)
    if failures:
        return Row(f"{name} (failed {failures.replace(' of ', '/')})", cells, "red")
    return Row(name, cells, "dim" if comparison.privileged(policy) else "")
