"""Rows of reported policies in the tables of flown ones, and tables of both on the tasks that they share."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.reported import ReportedFigures, reported_on, success_text, unflown
from indoor_explorers.evaluation.analysis.tables.policy_names import marked
from indoor_explorers.evaluation.analysis.tables.ratio_table import DECIMALS, bounded
from indoor_explorers.evaluation.drawing.formatting import (
    decimals_for,
    fixed,
    interval,
    percent,
    percent_interval,
    slug,
)
from indoor_explorers.evaluation.drawing.table import Cell, Column, Row, Table, words
from indoor_explorers.evaluation.harness.episodes.metrics import MEASURES
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import Estimate, bootstrap_mean, success_share

#: The columns of reported.csv.
COLUMNS = (
    *("scenario", "reported", "citation", "url", "metric", "episodes", "mean", "low", "high"),
    *("flown", "tasks", "flown_mean", "reported_mean", "mean_of_ratios", "ratio_low", "ratio_high", "bound"),
)
#: What the ratios of these tables are.
ABOUT = "Means over the tasks of both; ratios are flown / reported, their mean over tasks: below 1 the flown has less."


def figure(estimate: Estimate, metric: str, decimals: Callable[[float], int] = decimals_for) -> Cell:
    """Return a mean with its interval, a dash where there is none."""
    if math.isnan(estimate.mean):
        return Cell(fixed(None, 0))
    digits = 3 if metric.startswith("auc") else decimals(estimate.mean)
    return Cell(fixed(estimate.mean, digits), estimate.mean, interval(estimate, digits))


def _share(estimate: Estimate) -> Cell:
    if math.isnan(estimate.mean):
        return Cell(fixed(None, 0))
    return Cell(percent(estimate.mean), estimate.mean, percent_interval(estimate))


def success_cell(figures: ReportedFigures) -> Cell:
    """Return the share of successes where it is about the threshold of the scenario, else a dash."""
    return _share(figures.success) if figures.succeeds_at_threshold else Cell(fixed(None, 0))


def reported_cells(
    figures: ReportedFigures, times: Sequence[str], decimals: Callable[[float], int] = decimals_for
) -> list[Cell]:
    """Return the cells of a reported policy below the headings of flown ones: see :func:`~.policy_cells.headings`."""
    return [
        *(figure(figures.estimate(key), key, decimals) for key in times),
        success_cell(figures),
        Cell(fixed(None, 0)),
        figure(figures.estimate("auc"), "auc"),
        Cell(fixed(None, 0)),
    ]


def has_figure(cells: Sequence[Cell]) -> bool:
    """Return whether a row says anything; where it does not, the policy is left to the table beside."""
    return any(cell.value is not None for cell in cells)


def reported_tables(results: Results) -> list[Table]:
    """Return a table for each scenario and reported policy: the flown ones beside it on the tasks of both."""
    if not results.reported:
        return []
    comparisons = [Comparison(results.on_common_tasks, scenario) for scenario in results.scenarios]
    keys = [f"{number:02d}-{slug(each.scenario)}" for number, each in enumerate(comparisons, 1)]
    return [table for key, each in zip(keys, comparisons, strict=True) for table in beside_tables(each, key)]


def beside_tables(comparison: Comparison, key: str) -> list[Table]:
    """Return the tables of one scenario; their keys begin with ``key``."""
    found = reported_on(comparison) if comparison.groups else []
    return [_beside(figures, f"{key}-{slug(figures.policy.name)}") for figures in found]


def _beside(figures: ReportedFigures, key: str) -> Table:
    comparison, level = figures.comparison, figures.policy.level
    columns = [words("policy", 16)]
    for metric in figures.metrics:
        measure = MEASURES[metric]
        columns.append(Column(f"{measure.title} [{measure.unit}]" if measure.unit else measure.title))
        columns += [Column("flown / reported")] if figures.tasks else []
    columns += [Column(success_text(level))] if level is not None else []
    columns.append(Column("tasks" if figures.tasks else "episodes"))
    rows = [Row(marked(comparison.results, name), _flown_cells(figures, name)) for name in comparison.groups]
    rows += _shared_rows(figures) + [Row(f"{figures.name}, all", _own_cells(figures), "italic")]
    notes = [ABOUT] if figures.tasks else ["No task of both: the means are over different tasks, and not compared."]
    return Table(columns, rows, f"{comparison.title} beside {figures.name}", key, [*notes, figures.note])


def _flown_cells(figures: ReportedFigures, policy: str) -> list[Cell]:
    """Return the means of a flown policy over the shared tasks with their ratios; over all its tasks without any."""
    cells, comparison = [], figures.comparison
    for metric in figures.metrics:
        pairs = figures.pairs(policy, metric)
        if not figures.tasks:
            cells.append(figure(comparison.estimate(policy, metric), metric))
            continue
        cells.append(figure(bootstrap_mean(pairs.flown, maps=pairs.maps), metric))
        ratio, bound = pairs.ratio.of_tasks, pairs.censoring.bound
        around = "" if bound in (">", "<") else interval(ratio, DECIMALS)
        cells.append(Cell(bounded(fixed(ratio.mean, DECIMALS), bound), ratio.mean, around))
    shared = figures.shared(policy)
    if figures.policy.level is not None:
        success, places = figures.flown_success(policy), [place for each in shared.values() for place in each]
        chosen = None if success is None else success[places] if figures.tasks else success
        cells.append(_share(success_share([] if chosen is None else chosen)))
    return [*cells, Cell(str(len(shared) if figures.tasks else len(comparison.groups[policy])))]


def _shared_rows(figures: ReportedFigures) -> list[Row]:
    """Return the row of the reported policy on the shared tasks, where these are the same for all flown policies."""
    names = list(figures.comparison.groups)
    shared = [set(figures.shared(name)) for name in names]
    if not figures.tasks or any(each != shared[0] for each in shared):
        return []
    cells = []
    for metric in figures.metrics:
        pairs = figures.pairs(names[0], metric)
        cells += [figure(bootstrap_mean(pairs.reported, maps=pairs.maps), metric), Cell("1")]
    if figures.policy.level is not None:
        of_both = [each.success for each in figures.episodes if _key(each) in shared[0] and each.success is not None]
        cells.append(_share(success_share(of_both)))
    return [Row(f"{figures.name}, shared tasks", [*cells, Cell(str(len(shared[0])))], "italic")]


def _key(row: Any) -> tuple[str, int | None]:
    return row.map, row.seed


def _own_cells(figures: ReportedFigures) -> list[Cell]:
    cells = []
    for metric in figures.metrics:
        cells += [figure(figures.estimate(metric), metric), *([Cell()] if figures.tasks else [])]
    cells += [_share(figures.success)] if figures.policy.level is not None else []
    return [*cells, Cell(str(figures.count))]


def unflown_tables(results: Results) -> list[Table]:
    """Return a table for each scenario that only reported policies have."""
    return [_alone(scenario, figures) for scenario, figures in unflown(results).items()]


def _alone(scenario: str, reported: Sequence[ReportedFigures]) -> Table:
    held = {metric for each in reported for metric in each.metrics}
    metrics = [metric for metric in MEASURES if metric in held]
    titles = [f"{MEASURES[m].title} [{MEASURES[m].unit}]" if MEASURES[m].unit else MEASURES[m].title for m in metrics]
    levels = dict.fromkeys(each.policy.level for each in reported if each.policy.level is not None)
    rows = [
        Row(
            each.name,
            [
                *(figure(each.estimate(metric), metric) for metric in metrics),
                *(_share(each.success) if each.policy.level == level else Cell() for level in levels),
                Cell(str(each.count)),
            ],
        )
        for each in reported
    ]
    columns = [words("policy", 16), *map(Column, [*titles, *map(success_text, levels), "episodes"])]
    title = f"{scenario}: reported alone, nothing flown beside"
    return Table(columns, rows, title, f"reported-{slug(scenario)}", [each.note for each in reported])


def reported_csv_rows(results: Results) -> list[dict[str, Any]]:
    """Return the rows of reported.csv: by scenario, reported policy and metric, one for each flown policy or one."""
    found: list[dict[str, Any]] = []
    for scenario in results.scenarios:
        for figures in reported_on(Comparison(results.on_common_tasks, scenario)):
            for metric in figures.metrics:
                found += _csv_rows(figures, metric)
    return found + [
        row
        for figures in unflown(results).values()
        for each in figures
        for m in each.metrics
        for row in _csv_rows(each, m)
    ]


def _csv_rows(figures: ReportedFigures, metric: str) -> list[dict[str, Any]]:
    source, scenario = figures.policy.source, figures.comparison.scenario
    about = (scenario, figures.policy.name, source.citation, source.url, metric, figures.count)
    own = dict(zip(COLUMNS, (*about, *figures.estimate(metric)), strict=False))
    rows = []
    for policy in figures.comparison.groups if figures.tasks else ():
        pairs = figures.pairs(policy, metric)
        means = [float(np.mean(each)) if len(each) else math.nan for each in (pairs.flown, pairs.reported)]
        figures_of = (policy, len(pairs.flown), *means, *pairs.ratio.of_tasks, pairs.censoring.bound)
        rows.append(own | dict(zip(COLUMNS[9:], figures_of, strict=True)))
    return rows or [own]
