"""The report page: one HTML file with everything in it, the same bytes for the same results."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from indoor_explorers.env.files import written_whole
from indoor_explorers.evaluation.record import Record
from indoor_explorers.evaluation.report import facts
from indoor_explorers.evaluation.report.against import Against
from indoor_explorers.evaluation.report.charts import WHO, chart_data
from indoor_explorers.evaluation.report.comparison import Comparison
from indoor_explorers.evaluation.report.headline import headline
from indoor_explorers.evaluation.report.numbers import counted, percent
from indoor_explorers.evaluation.report.palette import COLOURS, Style, styles
from indoor_explorers.evaluation.report.replay import ending, replay_data
from indoor_explorers.evaluation.report.strips import swatch
from indoor_explorers.evaluation.report.tables import (
    COLUMNS,
    LISTED,
    map_table,
    paired_table,
    results_table,
    tally_table,
    troubles,
)
from indoor_explorers.evaluation.results import Results
from indoor_explorers.evaluation.statistics import CONFIDENCE, FEWEST, RESAMPLES

#: Bytes of the whole page that replays and charts may take, beside the 5 MB of plotly.js.
REPLAY_BYTES, CHART_BYTES = 3_000_000, 1_200_000


def write_report(results: Results, path: Path, *, title: str | None = None, against: Against | None = None) -> None:
    """Write one HTML file that shows ``results`` and needs nothing else, not even a network."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with written_whole(path) as partial:
        partial.write_text(render(results, title=title, against=against), encoding="utf-8", newline="\n")


def render(results: Results, *, title: str | None = None, against: Against | None = None) -> str:
    """Return the page as text."""
    looks = styles(results.policies)
    sections = [_section(results, name, number, looks) for number, name in enumerate(results.scenarios, 1)]
    return (
        _environment()
        .get_template("page.html")
        .render(
            title=title or "Exploration policies compared",
            subtitle=_subtitle(results),
            colours=COLOURS,
            sections=sections,
            against=against,
            columns=COLUMNS,
            listed=LISTED,
            swatches={name: swatch(look) for name, look in looks.items()},
            policies=results.policies,
            privileged=[name for name, about in results.policies.items() if about.get("privileged")],
            measures=facts.measures(),
            runs=facts.run_rows(results.runs),
            run_count=len(results.runs),
            commands=facts.commands(results.runs),
            interval={"confidence": percent(CONFIDENCE), "resamples": RESAMPLES, "fewest": FEWEST},
            plotly=Markup(get_plotlyjs().replace("</script", "<\\/script")),
        )
    )


@lru_cache(maxsize=1)
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("indoor_explorers.evaluation.report", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"json": embedded, "shown": facts.shown, "ending": ending, "percent": percent}
    environment.globals["include_raw"] = _raw
    return environment


def _raw(name: str) -> Markup:
    """Return one of the page's own style sheets or scripts as it is."""
    return Markup((Path(__file__).parent / name).read_text(encoding="utf-8"))


def embedded(data: Any) -> Markup:
    """Return JSON that can stand inside a script element whatever the names in it are."""
    text = json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return Markup(text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))


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


def _section(results: Results, name: str, number: int, looks: Mapping[str, Style]) -> Section:
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
        replay=replay_data(comparison, looks, REPLAY_BYTES // len(results.scenarios)) if flown else None,
    )


def _points(results: Results) -> int:
    """Return how many steps a chart may have for all charts to stay within their share of the page."""
    numbers = 9 if any(settings["team"] > 1 for settings in results.scenarios.values()) else 3
    curves = max(1, len(results.groups)) * numbers
    return int(min(480, max(60, CHART_BYTES / (curves * 2.7))))


def _subtitle(results: Results) -> list[str]:
    seeds = sorted({record.task.seed for record in results.records})
    phrases = [counted(len(results.policies), "policy"), counted(len(results.scenarios), "scenario")]
    phrases.append(counted(len(results.records), "episode"))
    if seeds:
        phrases.append(f"seeds {seeds[0]} to {seeds[-1]}" if len(seeds) > 1 else f"seed {seeds[0]}")
    return phrases
