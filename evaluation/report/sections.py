"""The data of one scenario for the template of the page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from indoor_explorers.evaluation.analysis import facts
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.failures import failed_or_ended
from indoor_explorers.evaluation.analysis.headline import headline
from indoor_explorers.evaluation.analysis.notes import detectable_notes, narrow_notes, unseen_notes
from indoor_explorers.evaluation.analysis.panels import ScenarioPanels, scenario_panels
from indoor_explorers.evaluation.analysis.panels.reported_chart import ReportedChart, reported_charts
from indoor_explorers.evaluation.analysis.reported import ReportedFigures, reported_on
from indoor_explorers.evaluation.analysis.tables.contrast_table import ContrastRow, contrast_table
from indoor_explorers.evaluation.analysis.tables.reported_table import (
    figure,
    has_figure,
    reported_table,
    success_cell,
)
from indoor_explorers.evaluation.analysis.tables.results_table import (
    DIVISOR,
    MeasureColumn,
    MeasureRow,
    columns_of,
    constant_columns,
    measures_table,
    results_table,
)
from indoor_explorers.evaluation.drawing.palette import Styles
from indoor_explorers.evaluation.drawing.table import Cell, Row, Table
from indoor_explorers.evaluation.harness.episodes.record import AXES, Record
from indoor_explorers.evaluation.harness.episodes.stored_names import MODELS, refusal
from indoor_explorers.evaluation.harness.results.coverage_threshold import CoverageThreshold
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.charts.interactive import WHO, chart_data, coverage_scopes, times_data
from indoor_explorers.evaluation.report.charts.reported_bars import reported_bars
from indoor_explorers.evaluation.report.charts.small_multiples import SmallMultiples, map_multiples
from indoor_explorers.evaluation.report.replay.explanations import Explaining
from indoor_explorers.evaluation.report.replay.selection import replay_data
from indoor_explorers.evaluation.statistics import FEWEST, Estimate

#: Limits of all replays and of all charts in bytes; plotly.js takes 5 MB besides.
REPLAY_BYTES, CHART_BYTES = 3_000_000, 1_200_000
#: Limit of the points of all episodes of a policy, which are in memory at once.
CHART_VALUES = 2_000_000
#: Names of the axes on the buttons of a chart.
AXIS_NAMES = {"steps": "Steps", "distance": "Distance", "seconds": "Thinking time", "bytes": "Bytes sent"}


@dataclass(frozen=True)
class TaskSummary:
    """The scenario as a task."""

    team: int
    phrases: list[str]
    denominator: str
    """What coverage is a share of."""
    setting_rows: list[tuple[str, str, str]]
    """Key, value and meaning of every setting."""


@dataclass(frozen=True)
class Sample:
    """What was flown."""

    policies: list[str]
    episodes: int
    """The largest number of episodes of a policy."""
    few: bool
    """Whether a policy flew too few episodes for an interval."""
    same_as: dict[str, str]
    """The policies that flew the same episodes as one listed before them, each with that one."""
    fixed_maps: int
    """Number of maps if the intervals hold for these maps alone; 0 if they hold for maps like these."""


@dataclass(frozen=True)
class SectionCharts:
    """The data of the section's charts; None where nothing was flown."""

    coverage: dict[str, Any] | None
    who: list[tuple[str, str]]
    """Whose coverage can be shown: team, worst or mean UAV."""
    axes: list[tuple[str, str]]
    """Key and title of each axis that coverage is drawn against."""
    times: dict[str, Any] | None
    thresholds: list[tuple[str, str]]
    """Key and title of each time that the chart can show, that of the scenario's threshold first."""
    multiples: SmallMultiples | None


@dataclass(frozen=True)
class SectionTables:
    """The section's tables."""

    columns: list[MeasureColumn]
    """Those of the results that are shown."""
    results: list[Row]
    """By policy, a cell for each column."""
    constant: list[tuple[MeasureColumn, Cell]]
    """The columns that are left out, as all policies have the same figure, with that."""
    measures: list[MeasureRow]
    baseline: str
    """The best-ranked policy, which the others are compared with."""
    contrasts: list[ContrastRow]
    notes: list[str]
    """Sentences below the results."""


@dataclass(frozen=True)
class SectionReported:
    """The reported policies of the scenario."""

    rows: list[Row]
    """Their rows below the results, a cell for each column."""
    tables: list[Table]
    """The flown policies beside each of them."""
    charts: list[tuple[ReportedChart, Markup]]


@dataclass(frozen=True)
class Section:
    """What the template shows of one scenario."""

    id: str
    name: str
    level: CoverageThreshold
    """The coverage threshold of the scenario."""
    headline: Markup
    task: TaskSummary
    sample: Sample
    charts: SectionCharts
    tables: SectionTables
    panels: ScenarioPanels
    failures: list[Record]
    """The episodes that failed or ended early."""
    replay: dict[str, Any] | None
    not_simulated: str
    """Why no episode can be simulated again; empty where they can."""
    reported: SectionReported | None
    """None where nothing is reported."""


def section_of(
    comparison: Comparison, section_id: str, styles: Styles, replays: int | None, explaining: Explaining
) -> Section:
    """Return the data of a scenario, with this number of ``replays``, or as many as fit, and their explanations."""
    limit, tables = REPLAY_BYTES // len(comparison.results.scenarios), _tables(comparison, styles)
    return Section(
        id=section_id,
        name=comparison.title,
        level=comparison.level,
        headline=headline(comparison),
        task=_task_summary(comparison),
        sample=_sample(comparison),
        charts=_charts(comparison, styles),
        tables=tables,
        panels=scenario_panels(comparison, styles),
        failures=failed_or_ended(comparison.records),
        replay=replay_data(comparison, styles, limit, replays, explaining) if comparison.records else None,
        not_simulated=refusal(comparison.results.scenarios[comparison.scenario], comparison.results.plugins, MODELS),
        reported=_reported(comparison, section_id, tables.columns, styles) if comparison.results.reported else None,
    )


def _reported(
    comparison: Comparison, section_id: str, columns: Sequence[MeasureColumn], styles: Styles
) -> SectionReported | None:
    found = reported_on(comparison) if comparison.groups else []
    if not found:
        return None
    charts = enumerate(reported_charts(comparison, styles))
    rows = [Row(each.name, [_reported_cell(each, column) for column in columns]) for each in found]
    return SectionReported(
        rows=[row for row in rows if has_figure(row.cells)],
        tables=list(map(reported_table, found)),
        charts=[(chart, reported_bars(chart, f"hatch-{section_id}-{number}")) for number, chart in charts],
    )


def _reported_cell(figures: ReportedFigures, column: MeasureColumn) -> Cell:
    """Return the cell of a reported policy below a column of the results; a dash where it was not reported."""
    if column.kind == "reached" and column.metric == figures.comparison.level.key:
        return success_cell(figures)
    if column.kind:
        return Cell("")
    (mean, low, high), divisor = figures.estimate(column.key), DIVISOR.get(column.key, 1.0)
    return figure(Estimate(mean / divisor, low and low / divisor, high and high / divisor), column.key)


def _task_summary(comparison: Comparison) -> TaskSummary:
    settings = comparison.results.scenarios[comparison.scenario]
    budgets = sorted({record.budget for record in comparison.records})
    shapes = sorted({record.floorplan.levels.size for record in comparison.records})
    return TaskSummary(
        team=settings["team"],
        phrases=facts.summary_line(settings, budgets, shapes),
        denominator=facts.denominator(settings),
        setting_rows=facts.setting_rows(settings),
    )


def _sample(comparison: Comparison) -> Sample:
    counts = [len(records) for records in comparison.groups.values()]
    return Sample(
        policies=list(comparison.groups),
        episodes=max(counts, default=0),
        few=any(count < FEWEST for count in counts),
        same_as=comparison.same_as,
        fixed_maps=0 if comparison.over_maps else comparison.map_count,
    )


def _charts(comparison: Comparison, styles: Styles) -> SectionCharts:
    who = [(each, WHO[each]) for each in coverage_scopes(comparison.results.scenarios[comparison.scenario])]
    if not comparison.records:
        return SectionCharts(None, who, [], None, [], None)
    coverage, times = chart_data(comparison, styles, _points(comparison.results)), times_data(comparison, styles)
    return SectionCharts(
        coverage=coverage,
        who=who,
        axes=[(axis["key"], AXIS_NAMES[axis["key"]]) for axis in coverage["axes"]],
        times=times,
        thresholds=[(level["key"], level["title"]) for level in times["levels"]],
        multiples=map_multiples(comparison, styles),
    )


def _tables(comparison: Comparison, styles: Styles) -> SectionTables:
    flown, columns = bool(comparison.records), columns_of(comparison.level)
    rows = results_table(comparison, styles) if flown else []
    reported = {metric for figures in reported_on(comparison) for metric in figures.metrics}
    constant = [each for each in constant_columns(columns, rows) if each[0].metric not in reported]
    kept = [place for place, column in enumerate(columns) if column not in [each for each, _ in constant]]
    return SectionTables(
        columns=[columns[place] for place in kept],
        results=[Row(policy, [cells[place] for place in kept]) for policy, cells, _ in rows],
        constant=constant,
        measures=measures_table(comparison),
        baseline=comparison.ranked_policies[0] if flown else "",
        contrasts=contrast_table(comparison, styles),
        notes=[*detectable_notes(comparison), *unseen_notes(comparison), *narrow_notes(comparison)] if flown else [],
    )


def _points(results: Results) -> int:
    """Return the number of points of a curve for which all charts stay within their limit."""
    who = max(len(coverage_scopes(settings)) for settings in results.scenarios.values())
    curves = max(1, len(results.groups)) * who * 3 * (1 + (len(AXES) - 1) / 2)
    episodes = max(map(len, results.groups.values()), default=1)
    return int(min(400, max(60, min(CHART_BYTES / (curves * 2.7), CHART_VALUES / (episodes * who)))))
