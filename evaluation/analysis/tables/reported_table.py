"""Rows of reported policies in the tables of flown ones, and tables of both on the tasks that they share."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import pandas as pd

from indoor_explorers.evaluation.analysis.reported import ReportedFigures, all_reported
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
APART = "No task of both: the means are over different tasks, and not compared."
ALONE = "Nothing was flown on this scenario."


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


def metric_title(metric: str) -> str:
    """Return the title of a metric with its unit."""
    measure = MEASURES[metric]
    return f"{measure.title} [{measure.unit}]" if measure.unit else measure.title


def has_figure(cells: Sequence[Cell]) -> bool:
    """Return whether a row says anything; where it does not, the policy is left to the table beside."""
    return any(cell.value is not None for cell in cells)


def reported_tables(results: Results) -> list[Table]:
    """Return a table for each scenario and reported policy: the flown ones beside it, on the tasks of both if any."""
    return [reported_table(figures) for figures in all_reported(results)]


def reported_table(figures: ReportedFigures) -> Table:
    """Return the table of a reported policy on a scenario."""
    comparison, level, shared = figures.comparison, figures.policy.level, figures.tasks > 0
    columns = [words("policy", 16)]
    for metric in figures.metrics:
        columns += [Column(metric_title(metric)), *([Column("flown / reported")] if shared else [])]
    columns += [Column(f"reached {100 * level:g} %")] if level is not None else []
    columns.append(Column("tasks" if shared else "episodes"))
    rows = [Row(marked(comparison.results, name), _flown_cells(figures, name)) for name in comparison.groups]
    rows += [*_shared_rows(figures), Row(f"{figures.name}, all" if shared else figures.name, _own(figures), "italic")]
    about = ABOUT if shared else APART if comparison.groups else ALONE
    key = f"reported-{slug(comparison.scenario)}-{slug(figures.policy.name)}"
    title = f"{comparison.title}{' beside' if comparison.groups else ':'} {figures.name}"
    return Table(columns, rows, title, key, [about, figures.note])


def _flown_cells(figures: ReportedFigures, policy: str) -> list[Cell]:
    """Return the means of a flown policy over the shared tasks with their ratios; over all its tasks without any."""
    comparison, shared, cells = figures.comparison, figures.shared(policy), list[Cell]()
    for metric in figures.metrics:
        if not figures.tasks:
            cells.append(figure(comparison.estimate(policy, metric), metric))
            continue
        pairs = figures.pairs(policy, metric)
        ratio, bound = pairs.ratio.of_tasks, pairs.censoring.bound
        around = "" if bound in (">", "<") else interval(ratio, DECIMALS)
        cells.append(figure(bootstrap_mean(pairs.flown, maps=pairs.maps), metric))
        cells.append(Cell(bounded(fixed(ratio.mean, DECIMALS), bound), ratio.mean, around))
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
    cells = list[Cell]()
    for metric in figures.metrics:
        pairs = figures.pairs(names[0], metric)
        cells += [figure(bootstrap_mean(pairs.reported, maps=pairs.maps), metric), Cell()]
    if figures.policy.level is not None:
        success = [row.success for row in figures.rows if (row.map, row.seed) in shared[0] and row.success is not None]
        cells.append(_share(success_share(success)))
    return [Row(f"{figures.name}, shared tasks", [*cells, Cell(str(len(shared[0])))], "italic")]


def _own(figures: ReportedFigures) -> list[Cell]:
    """Return the means over all rows."""
    cells = list[Cell]()
    for metric in figures.metrics:
        cells += [figure(figures.estimate(metric), metric), *([Cell()] if figures.tasks else [])]
    cells += [_share(figures.success)] if figures.policy.level is not None else []
    return [*cells, Cell(str(figures.count))]


def reported_csv(results: Results) -> pd.DataFrame:
    """Return the rows of reported.csv: by reported policy and metric, one for each flown policy, or one."""
    found = [row for figures in all_reported(results) for metric in figures.metrics for row in _rows(figures, metric)]
    return pd.DataFrame(found, columns=list(COLUMNS))


def _rows(figures: ReportedFigures, metric: str) -> list[dict[str, Any]]:
    source, scenario = figures.policy.source, figures.comparison.scenario
    about = (scenario, figures.policy.name, source.citation, source.url, metric, figures.count)
    own = dict(zip(COLUMNS, (*about, *figures.estimate(metric)), strict=False))
    rows = []
    for policy in figures.comparison.groups if figures.tasks else ():
        pairs = figures.pairs(policy, metric)
        means = (bootstrap_mean(each).mean for each in (pairs.flown, pairs.reported))
        paired = (policy, len(pairs.flown), *means, *pairs.ratio.of_tasks, pairs.censoring.bound)
        rows.append(own | dict(zip(COLUMNS[9:], paired, strict=True)))
    return rows or [own]
