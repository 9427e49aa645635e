"""What the page shows of one scenario, gathered for the template."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from indoor_explorers.evaluation.episodes.record import AXES, Record
from indoor_explorers.evaluation.report.analysis.comparison import Comparison
from indoor_explorers.evaluation.report.analysis.failures import failed_or_ended
from indoor_explorers.evaluation.report.charts.interactive import WHO, chart_data, times_data
from indoor_explorers.evaluation.report.charts.small_multiples import SmallMultiples, map_multiples
from indoor_explorers.evaluation.report.panels import ScenarioPanels, scenario_panels
from indoor_explorers.evaluation.report.replay.selection import replay_data
from indoor_explorers.evaluation.report.style.palette import Styles
from indoor_explorers.evaluation.report.summary import facts
from indoor_explorers.evaluation.report.summary.headline import headline
from indoor_explorers.evaluation.report.tables.contrast_table import ContrastRow, contrast_table
from indoor_explorers.evaluation.report.tables.measures_table import MeasureRow, measures_table
from indoor_explorers.evaluation.report.tables.results_table import Column, TableCell, columns_of, results_table
from indoor_explorers.evaluation.results.coverage_threshold import CoverageThreshold
from indoor_explorers.evaluation.results.results import Results
from indoor_explorers.evaluation.statistics import FEWEST

#: Bytes of the whole page that replays and charts may take, beside the 5 MB of plotly.js.
REPLAY_BYTES, CHART_BYTES = 3_000_000, 1_200_000
#: What the buttons of a chart call its axes.
AXIS_NAMES = {"steps": "Steps", "distance": "Distance", "seconds": "Thinking time", "bytes": "Bytes sent"}


@dataclass(frozen=True)
class Section:
    """What the template shows of one scenario."""

    id: str
    name: str
    settings: Mapping[str, Any]
    phrases: list[str]
    denominator: str
    level: CoverageThreshold
    """What the scenario is judged by."""
    headline: Markup
    episodes: int
    few: bool
    fixed_maps: int
    """How many maps the intervals speak about alone; 0 where they speak about maps like these."""
    who: tuple[str, ...]
    axes: list[tuple[str, str]]
    """Key and title of each axis that coverage is drawn against."""
    levels: list[tuple[str, str]]
    """Key and title of each time that its chart can show, that of its level first."""
    columns: tuple[Column, ...]
    table: list[tuple[str, list[TableCell]]]
    more: list[MeasureRow]
    baseline: str
    contrasts: list[ContrastRow]
    policies: list[str]
    multiples: SmallMultiples | None
    troubles: list[Record]
    panels: ScenarioPanels
    setting_rows: list[tuple[str, str, str]]
    chart: dict[str, Any] | None
    times: dict[str, Any] | None
    replay: dict[str, Any] | None


def section_of(comparison: Comparison, section_id: str, styles: Styles, replays: int | None = None) -> Section:
    """Gather what the page shows of a scenario, with so many ``replays`` or as many as fit."""
    results, name = comparison.results, comparison.scenario
    settings = results.scenarios[name]
    records = [record for group in comparison.groups.values() for record in group]
    flown = bool(records)
    chart = chart_data(comparison, styles, _points(results)) if flown else None
    times = times_data(comparison, styles) if flown else None
    return Section(
        id=section_id,
        name=name,
        settings=settings,
        phrases=facts.summary_line(
            settings, sorted({r.budget for r in records}), sorted({r.floorplan.shape for r in records})
        ),
        denominator=facts.denominator(settings),
        level=comparison.level,
        headline=headline(comparison),
        episodes=max((len(group) for group in comparison.groups.values()), default=0),
        few=any(len(group) < FEWEST for group in comparison.groups.values()),
        fixed_maps=0 if comparison.over_maps else comparison.map_count,
        who=WHO if settings["team"] > 1 else WHO[:1],
        axes=[(axis["key"], AXIS_NAMES[axis["key"]]) for axis in chart["axes"]] if chart else [],
        levels=[(level["key"], level["title"]) for level in times["levels"]] if times else [],
        columns=columns_of(comparison.level),
        table=results_table(comparison, styles) if flown else [],
        more=measures_table(comparison),
        baseline=comparison.ranked_policies[0] if flown else "",
        contrasts=contrast_table(comparison, styles),
        policies=list(comparison.groups),
        multiples=map_multiples(comparison, styles),
        troubles=failed_or_ended(records),
        panels=scenario_panels(comparison, styles),
        setting_rows=facts.setting_rows(settings),
        chart=chart,
        times=times,
        replay=replay_data(comparison, styles, REPLAY_BYTES // len(results.scenarios), replays) if flown else None,
    )


def _points(results: Results) -> int:
    """Return how many steps a chart may have for all charts to stay within their share of the page."""
    who = len(WHO) if any(settings["team"] > 1 for settings in results.scenarios.values()) else 1
    curves = max(1, len(results.groups)) * who * 3 * (1 + (len(AXES) - 1) / 2)
    return int(min(400, max(60, CHART_BYTES / (curves * 2.7))))
