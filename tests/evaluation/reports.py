"""Episodes flown on small maps for the tests of the report, and what a browser would make of a page."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from html.parser import HTMLParser
from typing import Any

import numpy as np
from rich.console import Console

from indoor_explorers.env import Briefing, Pilot, Policy, Scenario, View, scenario
from indoor_explorers.evaluation.analysis.tables.headline_table import headline_table
from indoor_explorers.evaluation.exports.latex import latex_tables
from indoor_explorers.evaluation.exports.markdown import markdown_tables
from indoor_explorers.evaluation.exports.scenario_tables import scenario_tables
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.results import Results

HOSTILE = ("a, b \"quoted\" </script><script>alert('x')</script>", "🚁 $x_1$ & <b>", "_it's {{ 7 * 7 }}")


class _Wanderer(Pilot):
    def __init__(self, briefing: Briefing, sweep: float, breaks: bool) -> None:
        self.rng, self.sweep, self.breaks, self.heading = briefing.rng, sweep, breaks, 0

    def act(self, view: View) -> int:
        if self.breaks and view.step == 3:
            raise ValueError("lost <the> way")
        legal = np.flatnonzero(view.legal[:4])
        if not view.legal[self.heading] or self.rng.random() > self.sweep:
            self.heading = int(self.rng.choice(legal)) if len(legal) else 4
        return self.heading


@dataclass(frozen=True, kw_only=True)
class Wander(Policy):
    """Fly straight on with a probability."""

    sweep: float = 0.8
    breaks: bool = False

    def pilot(self, briefing: Briefing) -> Pilot:
        return _Wanderer(briefing, self.sweep, self.breaks)


def task_on(team: int = 1, name: str = "rooms", **settings: Any) -> Scenario:
    changes = {"name": name, "team": team, "on_collision": "block", "goal": 0.995, **settings}
    return scenario("thesis-obstacles").for_evaluation().with_settings(changes)


def results_of(policies: dict[str, Wander], scenarios: Sequence[Scenario], episodes: int) -> Results:
    records = [
        record
        for each in scenarios
        for name, policy in policies.items()
        for record in fly(policy, name, each, [Task(each.name, 0, seed) for seed in range(episodes)])
    ]
    about = {
        name: {"use": "wander", "class": "tests:Wander", "privileged": False, "parameters": {"sweep": repr(p.sweep)}}
        for name, p in policies.items()
    }
    settings = {each.name: {"fingerprint": each.fingerprint, **each.model_dump(mode="json")} for each in scenarios}
    runs_of = [{"command": "indoor-explorers compare --out a", "python": "3.11", "cores": 2}]
    return Results(about, settings, runs_of, records)


def texts_of(results: Results) -> list[str]:
    """Return what the terminal, on one line, Markdown and LaTeX say about results."""
    tables, console = scenario_tables(results), Console(width=200, markup=False)
    with console.capture() as shown:
        console.print(headline_table(results, 200))
    return [" ".join(shown.get().split()), markdown_tables(tables), latex_tables(tables)]


class Page(HTMLParser):
    """Collects what a browser would make of a page."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: list[tuple[dict[str, str | None], str]] = []
        self.figures: dict[tuple[str, str], list[float]] = {}
        self.text = ""
        self._row = self._metric = ""
        self._script: dict[str, str | None] | None = None
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        self.tags.append((tag, found))
        self._script = found if tag == "script" else None
        self._row = str(found["data-policy"]) if "data-policy" in found else self._row
        self._metric = str(found.get("data-metric", "")) if tag == "td" else self._metric
        if tag == "data" and "data-metric" in found:  # named below the table, as it is the same for all
            self.figures.setdefault(("", str(found["data-metric"])), []).append(float(str(found["value"])))
        elif tag == "data" and self._metric:
            self.figures.setdefault((self._row, self._metric), []).append(float(str(found["value"])))

    def handle_endtag(self, tag: str) -> None:
        self._script = None if tag == "script" else self._script

    def handle_data(self, data: str) -> None:
        if self._script is not None:
            self.scripts.append((self._script, data))
        else:
            self.text += data

    def data(self, prefix: str) -> list[Any]:
        return [json.loads(text) for about, text in self.scripts if str(about.get("id", "")).startswith(prefix)]
