"""The report page: one self-contained HTML file, the same bytes for the same results.

A page of more than :data:`WHOLE` bytes leaves its scenarios to files beside it, which it loads when asked to.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from indoor_explorers.env.files import write_whole
from indoor_explorers.evaluation.analysis.against import Against
from indoor_explorers.evaluation.analysis.best_planner import against_best_planner
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.facts import shown
from indoor_explorers.evaluation.analysis.failures import ending
from indoor_explorers.evaluation.analysis.panels import sweep_sections
from indoor_explorers.evaluation.analysis.shown_best import BOLD
from indoor_explorers.evaluation.analysis.tables.origin_table import origin_tables
from indoor_explorers.evaluation.analysis.tables.planner_table import planner_table
from indoor_explorers.evaluation.analysis.tables.ratio_table import bound_notes, ratio_tables
from indoor_explorers.evaluation.drawing.dot_plots import swatch
from indoor_explorers.evaluation.drawing.formatting import counted, percent, seed_span
from indoor_explorers.evaluation.drawing.palette import INKS, Styles, policy_styles
from indoor_explorers.evaluation.harness.results.coverage_threshold import shared
from indoor_explorers.evaluation.harness.results.origin_ratios import ratios_by_origin
from indoor_explorers.evaluation.harness.results.ratios import Ratios
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.custom_panels import custom_panels
from indoor_explorers.evaluation.report.replay.explanations import Explaining
from indoor_explorers.evaluation.report.sections import TaskSummary, section_of
from indoor_explorers.evaluation.report.summary.definitions import definitions
from indoor_explorers.evaluation.report.summary.overview import overview
from indoor_explorers.evaluation.report.summary.provenance import provenance
from indoor_explorers.evaluation.statistics import CONFIDENCE, FEWEST

#: Bytes of a page above which its scenarios are in files beside it, and how the name of their folder ends.
WHOLE, BESIDE = 16_000_000, "_files"
#: Limit of listed episodes of a scenario that failed or ended early.
LISTED = 60


def write_report(
    results: Results,
    path: Path,
    *,
    title: str | None = None,
    against: Against | None = None,
    replays: int | None = None,
    ratio_to: Sequence[str] | None = None,
    panels: Sequence[str] = (),
    explanations: float | None = None,
    whole: bool = False,
) -> None:
    """Write an HTML file that shows ``results`` and needs no network.

    It needs no other files either, unless it would have more than :data:`WHOLE` bytes: then each scenario is in a file
    of the folder ``NAME_files`` beside ``NAME.html``. ``whole`` keeps it in one file all the same.

    ``against`` adds what changed since other results. ``replays`` is the number of episodes to embed for each scenario;
    by default as many as keep the page under 10 MB. ``ratio_to`` names the baselines of the ratios of steps, see
    :func:`~indoor_explorers.evaluation.harness.experiment.selection.chosen_baselines`. ``panels`` names plug-ins, see
    :mod:`indoor_explorers.evaluation.report.custom_panels`. ``explanations`` are the seconds for which embedded
    episodes thought, together, that are flown again to explain them; by default few, see
    :class:`~indoor_explorers.evaluation.report.replay.explanations.Explaining`.
    """
    page = _Page(results, title, against, replays, ratio_to, panels, explanations)
    path.parent.mkdir(parents=True, exist_ok=True)
    parts = {} if whole or page.size <= WHOLE else dict(page.parts(f"{path.stem}{BESIDE}"))
    for name, text in parts.items():
        (path.parent / name).parent.mkdir(exist_ok=True)
        write_whole(path.parent / name, text)
    write_whole(path, page.text(list(parts)))
    remove_parts(path, kept=parts)


def remove_parts(path: Path, *, kept: Collection[str] = ()) -> None:
    """Delete the files beside a page that another page left there."""
    folder = path.with_name(f"{path.stem}{BESIDE}")
    for file in folder.glob("part-s*.js"):
        if f"{folder.name}/{file.name}" not in kept:
            file.unlink()
    if folder.is_dir() and not any(folder.iterdir()):
        folder.rmdir()


def render(
    results: Results,
    *,
    title: str | None = None,
    against: Against | None = None,
    replays: int | None = None,
    ratio_to: Sequence[str] | None = None,
    panels: Sequence[str] = (),
    explanations: float | None = None,
) -> str:
    """Return the page, in one piece, as text; for its arguments see :func:`write_report`."""
    return _Page(results, title, against, replays, ratio_to, panels, explanations).text()


class _Page:
    """A page and its sections of scenarios, whose data is dropped as soon as it is text."""

    def __init__(
        self,
        results: Results,
        title: str | None,
        against: Against | None,
        replays: int | None,
        ratio_to: Sequence[str] | None,
        panels: Sequence[str],
        explanations: float | None,
    ) -> None:
        ratios = Ratios.of(results, ratio_to)
        common, styles = results.on_common_tasks, policy_styles(results.policies)
        comparisons = {f"s{number}": Comparison(common, name) for number, name in enumerate(results.scenarios, 1)}
        self._shown = {
            "title": title or "Exploration policies compared",
            "subtitle": _subtitle(results),
            "overview": overview(results, comparisons, styles),
            "against": against,
            "ratios": ratio_tables(ratios),
            "best_planner": planner_table(against_best_planner(comparisons.values())),
            "origin_ratios": origin_tables(ratios_by_origin(ratios)),
            "ratio_notes": bound_notes(ratios.rows),
            "sweeps": sweep_sections(common, styles),
            "custom_panels": custom_panels(common, panels),
            "definitions": definitions(shared(results.levels), results.measures),
            "policies": _policies(results, styles),
            "provenance": provenance(results),
            "reported": results.reported,
        }
        several, explaining = len(comparisons) > 1, Explaining(results, explanations)
        template = _environment().get_template("scenario.html")
        self._stubs: list[_Stub] = []
        self._bodies: list[Markup] = []
        self._levels = False
        for section_id, comparison in comparisons.items():
            section = section_of(comparison, section_id, styles, replays, explaining)
            self._levels |= section.replay is not None and any("levels" in each for each in section.replay["episodes"])
            self._stubs.append(_Stub(section_id, section.name, section.task, section.headline))
            self._bodies.append(Markup(template.render(self._shown, section=section, several=several)))

    @property
    def size(self) -> int:
        """The approximate number of bytes of the page in one piece."""
        return len(get_plotlyjs()) + sum(map(len, self._bodies))

    def parts(self, folder: str) -> Iterator[tuple[str, str]]:
        """Yield the file of each scenario, by its path from the page's folder; other contents have other names."""
        for stub, body in zip(self._stubs, self._bodies, strict=True):
            text = f"Parts.receive({json.dumps(stub.id)}, {json.dumps(body)});\n"
            yield f"{folder}/part-{stub.id}-{sha256(text.encode()).hexdigest()[:12]}.js", text

    def text(self, parts: Sequence[str] = ()) -> str:
        """Return the page with its scenarios, or with the files to load them from."""
        template = _environment().get_template("page.html")
        files = [quote(name) for name in parts]
        return template.render(self._shown, sections=self._stubs, bodies=self._bodies, parts=files, levels=self._levels)


class _Stub(NamedTuple):
    """What the page has of a scenario that is in a file beside it."""

    id: str
    name: str
    task: TaskSummary
    headline: Markup


@dataclass(frozen=True)
class ShownPolicies:
    """What the template shows beside the names of policies."""

    facts: Mapping[str, Mapping[str, Any]]
    privileged: list[str]
    uses_generator: list[str]
    batched: list[str]
    failed_checks: dict[str, str]
    exposed: list[str]
    swatches: dict[str, Markup]
    """Line and marker of each policy, as in the charts."""


def _policies(results: Results, styles: Styles) -> ShownPolicies:
    return ShownPolicies(
        results.policies,
        results.privileged_policies,
        results.generator_policies,
        results.batched_policies,
        results.failed_checks,
        results.exposed_policies,
        {name: swatch(style) for name, style in styles.items()},
    )


@lru_cache(maxsize=1)
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("indoor_explorers.evaluation.report", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"json": embedded, "shown": shown, "ending": ending, "percent": percent}
    environment.globals |= {
        "include_raw": _raw,
        "plotly": Markup(get_plotlyjs().replace("</script", "<\\/script")),
        "colours": INKS,
        "interval": {"confidence": percent(CONFIDENCE), "fewest": FEWEST},
        "listed": LISTED,
        "bold": BOLD,
    }
    return environment


def _raw(name: str) -> Markup:
    """Return a style sheet or script of the page without escaping."""
    return Markup((Path(__file__).parent / "scripts" / name).read_text(encoding="utf-8"))


def embedded(data: Any) -> Markup:
    """Return JSON that is safe inside a script element whatever names it contains."""
    text = json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return Markup(text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))


def _subtitle(results: Results) -> list[str]:
    phrases = list(results.suite_run.phrases) if results.suite_run else []
    phrases += [counted(len(results.policies), "policy"), counted(len(results.scenarios), "scenario")]
    phrases.append(counted(len(results.records), "episode"))
    phrases += [counted(len(results.reported), "reported policy")] if results.reported else []
    return [*phrases, *filter(None, [seed_span(record.task.seed for record in results.records)])]
