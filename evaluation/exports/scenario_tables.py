"""The tables of Markdown and LaTeX: the figures of the terminal's table, each with its interval."""

from __future__ import annotations

from collections.abc import Sequence

from indoor_explorers.evaluation.analysis.comparability import missing_episodes
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.facts import denominator
from indoor_explorers.evaluation.analysis.notes import narrow_notes, scenario_notes
from indoor_explorers.evaluation.analysis.reported import reported_on
from indoor_explorers.evaluation.analysis.shown_best import BOLD
from indoor_explorers.evaluation.analysis.tables.policy_cells import (
    best_of,
    headings,
    ratio_cells,
    reference_of,
    result_cells,
)
from indoor_explorers.evaluation.analysis.tables.policy_names import footnotes, marked
from indoor_explorers.evaluation.analysis.tables.reported_table import has_figure, reported_cells
from indoor_explorers.evaluation.drawing.formatting import percent, slug, span
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row, Table
from indoor_explorers.evaluation.harness.results.coverage_threshold import T99, CoverageThreshold, tabled
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import CONFIDENCE, FEWEST


def scenario_tables(results: Results) -> list[Table]:
    """Return a table for each scenario that was flown, with the columns of the terminal's table at its widest."""
    comparisons = {
        f"{number:02d}-{slug(name)}": Comparison(results.on_common_tasks, name)
        for number, name in enumerate(results.scenarios, 1)
    }
    return [
        _table(each, key, missing_episodes(results, each.scenario)) for key, each in comparisons.items() if each.groups
    ]


def _table(comparison: Comparison, key: str, missing: Sequence[str]) -> Table:
    results, level, best = comparison.results, comparison.level, best_of(comparison)
    known = reference_of(results) if results.references.get(comparison.scenario) else None
    shown = ["policy", *headings([level])]
    shown += ["T99 / bound"] if level == T99 else []
    shown += [f"{level.title} / {known}"] if known else []
    rows = [
        Row(
            marked(results, policy),
            [
                *result_cells(comparison, policy, tabled([level]), best, lambda mean: 1),
                *ratio_cells(comparison, policy, to_bound=level == T99, to_reference=known is not None),
            ],
        )
        for policy in comparison.groups
    ]
    for figures in reported_on(comparison):
        cells = reported_cells(figures, tabled([level]), lambda mean: 1)
        if has_figure(cells):
            rows.append(Row(figures.name, cells + [Cell()] * (len(shown) - 1 - len(cells))))
    notes = [*caption(comparison), *missing, *(each.note for each in reported_on(comparison))]
    return Table(list(map(Column, shown)), rows, comparison.title, key, notes)


def caption(comparison: Comparison) -> list[str]:
    """Return the sentences that explain a table's figures."""
    counts = [len(records) for records in comparison.groups.values()]
    limit = span(record.budget for record in comparison.records)
    settings = comparison.results.scenarios[comparison.scenario]
    return [
        f"{span(counts)} episode{'s' * (max(counts) > 1)} of each policy on {comparison.maps_flown}"
        f"{_of_suite(comparison)}.",
        _interval_kind(comparison, min(counts)),
        f"Coverage is the {denominator(settings)}.",
        f"{_times(comparison.level)}; an episode that never reaches it counts as its budget of {limit} steps.",
        *(["A dash: the goal of this scenario is below that threshold."] if comparison.level != T99 else []),
        *([BOLD] if len(comparison.ranked_policies) > 1 else []),
        *scenario_notes(comparison),
        *narrow_notes(comparison),
        *(["Policies that know the map are not ranked."] if any(map(comparison.privileged, comparison.groups)) else []),
        *footnotes(comparison.results, comparison.groups),
    ]


def _of_suite(comparison: Comparison) -> str:
    run = comparison.results.suite_run
    return f"; {', '.join(run.phrases)}" if run else ""


def _times(level: CoverageThreshold) -> str:
    """Define the times of the scenario's thresholds."""
    levels = [CoverageThreshold(key) for key in level.times]
    titles, shares = (" and ".join(words) for words in zip(*((e.title, e.percent) for e in levels), strict=True))
    return f"{titles} {'are the first steps' if len(levels) > 1 else 'is the first step'} with {shares} coverage"


def _interval_kind(comparison: Comparison, fewest: int) -> str:
    if fewest < FEWEST:
        return f"Means; fewer than {FEWEST} episodes get no interval."
    few = "this map alone" if comparison.map_count == 1 else "these maps alone"
    scope = "maps like these" if comparison.over_maps else few
    return f"Means with their {percent(CONFIDENCE)} bootstrap intervals over {scope}; shares reached with exact ones."
