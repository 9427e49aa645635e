"""The report page: one HTML file with everything in it, the same bytes for the same results."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from indoor_explorers.env.files import written_whole
from indoor_explorers.evaluation.report.analysis.comparison import Comparison
from indoor_explorers.evaluation.report.analysis.failures import ending
from indoor_explorers.evaluation.report.changes.against import Against
from indoor_explorers.evaluation.report.charts.dot_plots import swatch
from indoor_explorers.evaluation.report.charts.small_multiples import scenario_multiples
from indoor_explorers.evaluation.report.panels import sweep_sections
from indoor_explorers.evaluation.report.sections import section_of
from indoor_explorers.evaluation.report.style.formatting import counted, percent
from indoor_explorers.evaluation.report.style.palette import COLOURS, policy_styles
from indoor_explorers.evaluation.report.summary import facts
from indoor_explorers.evaluation.report.summary.comparability import judged, on_common_tasks
from indoor_explorers.evaluation.report.summary.definitions import definitions
from indoor_explorers.evaluation.report.summary.overview import lead, line
from indoor_explorers.evaluation.report.summary.reproduce import experiment_files, row_command
from indoor_explorers.evaluation.report.tables.ratio_table import ratio_tables
from indoor_explorers.evaluation.results.coverage_threshold import shared
from indoor_explorers.evaluation.results.ratios import Ratios
from indoor_explorers.evaluation.results.results import Results
from indoor_explorers.evaluation.statistics import CONFIDENCE, FEWEST

#: The most failed or early ended episodes that a scenario lists.
LISTED = 60


def write_report(
    results: Results,
    path: Path,
    *,
    title: str | None = None,
    against: Against | None = None,
    replays: int | None = None,
    ratio_to: Sequence[str] | None = None,
) -> None:
    """Write one HTML file that shows ``results`` and needs nothing else, not even a network.

    ``against`` adds what changed since other results. With ``replays`` it holds that many episodes of each scenario;
    else as many as keep it under 10 MB. ``ratio_to`` names the policies whose steps those of all are divided by, see
    :func:`~indoor_explorers.evaluation.experiment.selection.chosen_baselines`.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with written_whole(path) as partial:
        text = render(results, title=title, against=against, replays=replays, ratio_to=ratio_to)
        partial.write_text(text, encoding="utf-8", newline="\n")


def render(
    results: Results,
    *,
    title: str | None = None,
    against: Against | None = None,
    replays: int | None = None,
    ratio_to: Sequence[str] | None = None,
) -> str:
    """Return the page as text; its arguments are those of :func:`write_report`."""
    common = on_common_tasks(results)
    styles = policy_styles(results.policies)
    comparisons = [(f"s{number}", Comparison(common, name)) for number, name in enumerate(results.scenarios, 1)]
    return (
        _environment()
        .get_template("page.html")
        .render(
            title=title or "Exploration policies compared",
            subtitle=_subtitle(results),
            colours=COLOURS,
            against=against,
            ratios=ratio_tables(Ratios.of(results, ratio_to)),
            verdict=judged(results),
            lead=lead([each for _, each in comparisons]),
            level=shared(results.levels),
            lines=[line(each, section_id) for section_id, each in comparisons],
            panels=scenario_multiples(comparisons, styles),
            sections=[section_of(each, section_id, styles, replays) for section_id, each in comparisons],
            sweeps=sweep_sections(common, styles),
            listed=LISTED,
            swatches={name: swatch(style) for name, style in styles.items()},
            policies=results.policies,
            privileged=results.privileged_policies,
            definitions=definitions(shared(results.levels)),
            runs=facts.run_rows(results.runs),
            run_count=len(results.runs),
            commands=facts.commands(results.runs),
            row_commands=_row_commands(results),
            experiments=experiment_files(results),
            interval={"confidence": percent(CONFIDENCE), "fewest": FEWEST},
            plotly=Markup(get_plotlyjs().replace("</script", "<\\/script")),
        )
    )


def _row_commands(results: Results) -> list[tuple[str, str, str]]:
    """Return (scenario, policy, command) of each row of the results tables that can be made again by itself."""
    rows = [(scenario, policy, row_command(results, scenario, policy)) for scenario, policy in results.groups]
    return [row for row in rows if row[2]]


@lru_cache(maxsize=1)
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("indoor_explorers.evaluation.report", "templates"),
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
    return Markup((Path(__file__).parent / "scripts" / name).read_text(encoding="utf-8"))


def embedded(data: Any) -> Markup:
    """Return JSON that can stand inside a script element whatever the names in it are."""
    text = json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return Markup(text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))


def _subtitle(results: Results) -> list[str]:
    seeds = sorted({record.task.seed for record in results.records})
    phrases = [counted(len(results.policies), "policy"), counted(len(results.scenarios), "scenario")]
    phrases.append(counted(len(results.records), "episode"))
    if seeds:
        phrases.append(f"seeds {seeds[0]} to {seeds[-1]}" if len(seeds) > 1 else f"seed {seeds[0]}")
    return phrases
