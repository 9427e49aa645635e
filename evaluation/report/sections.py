"""What the page shows of one scenario, gathered for the template."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from indoor_explorers.evaluation.record import Record
from indoor_explorers.evaluation.report import facts
from indoor_explorers.evaluation.report.charts import WHO, chart_data
from indoor_explorers.evaluation.report.comparison import Comparison
from indoor_explorers.evaluation.report.headline import headline
from indoor_explorers.evaluation.report.palette import Style
from indoor_explorers.evaluation.report.replay import replay_data
from indoor_explorers.evaluation.report.tables import map_table, paired_table, results_table, tally_table, troubles
from indoor_explorers.evaluation.results import Results
from indoor_explorers.evaluation.statistics import FEWEST

#: Bytes of the whole page that replays and charts may take, beside the 5 MB of plotly.js.
REPLAY_BYTES, CHART_BYTES = 3_000_000, 1_200_000


@dataclass(frozen=True)
class Section:
    """What the template shows of one scenario."""

    id: str
    name: str
    settings: Mapping[str, Any]
    phrases: list[str]
    denominator: str
    headline: Markup
    episodes: int
    few: bool
    who: tuple[str, ...]
    table: list[Any]
    baseline: str
    paired: list[Any]
    policies: list[str]
    maps: list[Any]
    tallies: list[str]
    tally_rows: list[Any]
    troubles: list[Record]
    setting_rows: list[tuple[str, str, str]]
    chart: dict[str, Any] | None
    replay: dict[str, Any] | None


def section_of(
    results: Results, name: str, number: int, looks: Mapping[str, Style], replays: int | None = None
) -> Section:
    """Gather what the page shows of the scenario ``name``, the ``number``-th from 1."""
    comparison = Comparison(results, name)
    settings = results.scenarios[name]
    records = [record for group in comparison.groups.values() for record in group]
    flown = bool(records)
    baseline, paired = paired_table(comparison, looks) if flown else ("", [])
    return Section(
        id=f"s{number}",
        name=name,
        settings=settings,
        phrases=facts.summary_line(
            settings, sorted({r.budget for r in records}), sorted({r.floorplan.shape for r in records})
        ),
        denominator=facts.denominator(settings),
        headline=headline(comparison),
        episodes=max((len(group) for group in comparison.groups.values()), default=0),
        few=any(len(group) < FEWEST for group in comparison.groups.values()),
        who=WHO if settings["team"] > 1 else WHO[:1],
        table=results_table(comparison, looks) if flown else [],
        baseline=baseline,
        paired=paired,
        policies=list(comparison.groups),
        maps=map_table(comparison),
        tallies=comparison.tallies,
        tally_rows=tally_table(comparison),
        troubles=troubles(comparison),
        setting_rows=facts.setting_rows(settings),
        chart=chart_data(comparison, looks, _points(results)) if flown else None,
        replay=replay_data(comparison, looks, REPLAY_BYTES // len(results.scenarios), replays) if flown else None,
    )


def _points(results: Results) -> int:
    """Return how many steps a chart may have for all charts to stay within their share of the page."""
    numbers = 9 if any(settings["team"] > 1 for settings in results.scenarios.values()) else 3
    curves = max(1, len(results.groups)) * numbers
    return int(min(480, max(60, CHART_BYTES / (curves * 2.7))))
