from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from indoor_explorers.env import Briefing, Pilot, Policy, Scenario, View, scenario
from indoor_explorers.env.maps.sources import ThesisMaps
from indoor_explorers.env.scenario import Lidar, Radio
from indoor_explorers.evaluation.experiment import Task
from indoor_explorers.evaluation.report import headline_table, write_figures, write_report
from indoor_explorers.evaluation.report.comparison import Comparison
from indoor_explorers.evaluation.report.headline import headline
from indoor_explorers.evaluation.report.page import render
from indoor_explorers.evaluation.results import Results
from indoor_explorers.evaluation.runner import fly

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


@pytest.fixture(scope="module")
def results() -> Results:
    policies = {"straight": Wander(sweep=0.95), "wavy": Wander(sweep=0.6), "broken": Wander(breaks=True)}
    found = results_of(policies, [task_on(), task_on(4, "four", **{"radio.model": "unlimited"})], 6)
    found.policies["wavy"]["privileged"] = True
    return found


@pytest.fixture(scope="module")
def hostile() -> Results:
    policies = {name: Wander(sweep=sweep) for name, sweep in zip(HOSTILE, (0.95, 0.8, 0.3), strict=True)}
    return results_of(policies, [task_on(name="</script><img src=x onerror=alert(2)> 🏢")], 3)


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
        if tag == "data" and self._metric:
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


@pytest.fixture(scope="module")
def page(results: Results) -> Page:
    return Page(render(results))


def test_a_page_loads_nothing(page: Page) -> None:
    for tag, about in page.tags:
        assert not {"src", "srcset", "action", "background", "poster"} & about.keys(), (tag, about)
        assert tag not in ("link", "iframe", "object", "embed", "img", "base", "form")
        assert str(about.get("href", "#")).startswith("#")
    policy = next(about["content"] for _, about in page.tags if about.get("http-equiv") == "Content-Security-Policy")
    assert "default-src 'none'" in str(policy)
    assert "http" not in str(policy)


def test_equal_results_give_equal_bytes(results: Results, tmp_path: Path) -> None:
    write_report(results, tmp_path / "new" / "a.html")
    again = Results(results.policies, results.scenarios, results.runs, list(results.records))
    write_report(again, tmp_path / "b.html")
    assert (tmp_path / "new" / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_figures_of_the_table_are_those_of_the_summary(results: Results, page: Page) -> None:
    summary = results.summary()
    for metric in ("t90", "t99", "auc", "path_length", "overlap", "collisions", "messages_bytes", "latency_p99_us"):
        for policy in results.policies:
            rows = summary[(summary.policy == policy) & (summary.metric == metric)]
            assert page.figures[policy, metric] == pytest.approx(list(rows["mean"]))
    assert page.figures["broken", "failures"] == [6, 6]


def test_failures_are_told_with_their_cause(page: Page) -> None:
    assert "ValueError: lost <the> way" in page.text
    assert "knows the map" in page.text
    assert "share of the free cells reachable from the spawns" in page.text
    assert "indoor-explorers compare --out a" in page.text


def test_hostile_names_are_only_text(hostile: Results) -> None:
    page = Page(render(hostile, title="<script>alert(3)</script>"))
    executable = [text for about, text in page.scripts if about.get("type") != "application/json"]
    assert len(executable) == 4
    assert not any("alert(" in text for text in executable if len(text) < 1_000_000)
    assert {name["name"] for name in page.data("chart-data")[0]["policies"]} == set(HOSTILE)
    assert {name["name"] for name in page.data("replay-data")[0]["policies"]} == set(HOSTILE)
    assert all(name in page.text for name in HOSTILE)
    assert "49" not in re.findall(r"_it's (\S+)", page.text)


def test_too_few_episodes_get_dots_and_no_interval(hostile: Results) -> None:
    page = Page(render(hostile))
    assert not re.search(r"\[\d+\.\d+, \d", page.text)
    assert "too few for an interval" in page.text
    assert sum(tag == "circle" and about["class"] == "dot" for tag, about in page.tags) >= 9
    curves = page.data("chart-data")[0]["policies"][0]["curves"]["team"]
    assert len(curves["each"]) == 3
    assert "low" not in curves


def test_enough_episodes_get_intervals(page: Page) -> None:
    assert re.search(r"\[\d+\.\d+, \d", page.text)
    assert page.data("chart-data")[1]["who"] == ["team", "worst", "mean"]


def _with_t99(results: Results, policy: str, shift: Sequence[int]) -> Results:
    """Return a copy in which a policy's T99 is that of ``straight`` shifted."""
    straight = {r.task: r.metrics["t99"] or 100.0 for r in results.records if r.policy == "straight"}
    records = []
    for record in results.records:
        late = straight[record.task] + (shift[record.task.seed] if record.policy == policy else 0)
        records.append(replace(record, metrics=record.metrics | {"t99": late}))
    return Results(results.policies, results.scenarios, results.runs, records)


@pytest.mark.parametrize(
    ("shift", "words"),
    [
        ([9, 10, 11, 9, 10, 11], "an interval that leaves out 0"),
        ([-9, 10, -11, 9, -8, 12], "contains 0: no difference between the two was shown"),
        ([0] * 6, "share the lowest mean T99"),
    ],
)
def test_a_headline_claims_only_what_was_shown(results: Results, shift: list[int], words: str) -> None:
    two = Results(
        {name: results.policies[name] for name in ("straight", "broken")},
        results.scenarios,
        [],
        [record for record in results.records if record.policy != "wavy"],
    )
    assert words in headline(Comparison(_with_t99(two, "broken", shift), "rooms"))


def test_a_headline_without_rivals_or_success(results: Results) -> None:
    alone = [record for record in results.records if record.policy == "broken"]
    policies = {"broken": results.policies["broken"]}
    nobody = headline(Comparison(Results(policies, results.scenarios, [], alone), "rooms"))
    assert "No policy reached 99 %" in nobody
    there = [replace(record, metrics=record.metrics | {"t99": 9.0}) for record in alone]
    assert "no other policy" in headline(Comparison(Results(policies, results.scenarios, [], there), "rooms"))


def test_results_without_episodes_still_make_a_page(results: Results, tmp_path: Path) -> None:
    empty = Results(results.policies, results.scenarios, [], [])
    assert "No episode of this scenario" in render(empty)
    assert write_figures(empty, tmp_path) == []
    assert "no scenario" in render(Results({}, {}, [], []))


def test_maps_get_a_table_of_their_own(results: Results) -> None:
    records = [
        replace(r, task=r.task._replace(map_index=r.task.seed % 2), floorplan=replace(r.floorplan, name=f"house-{k}"))
        for r in results.records
        for k in [r.task.seed % 2]
    ]
    text = Page(render(Results(results.policies, results.scenarios, results.runs, records))).text
    assert "T99 by map" in text
    assert "house-1" in text


def test_a_big_map_makes_no_big_page(tmp_path: Path) -> None:
    hall = Scenario(
        name="hall",
        team=2,
        map=ThesisMaps(height=300, width=400, obstacles=500, obstacle_size=(3, 20)),
        lidar=Lidar(range=25.0),
        radio=Radio(model="unlimited"),
        on_collision="block",
        budget=3000,
    ).for_evaluation()
    found = results_of({"straight": Wander(sweep=0.98), "wavy": Wander(sweep=0.9)}, [hall], 1)
    write_report(found, tmp_path / "report.html")
    assert (tmp_path / "report.html").stat().st_size < 10_000_000
    episode = Page((tmp_path / "report.html").read_text(encoding="utf-8")).data("replay-data")[0]["episodes"][0]
    assert len(episode["flights"]) == 2
    assert episode["height"] == 300


def test_figures_are_deterministic(hostile: Results, tmp_path: Path) -> None:
    first, second = write_figures(hostile, tmp_path / "a"), write_figures(hostile, tmp_path / "b")
    assert {path.suffix for path in first} == {".svg", ".png", ".pdf"}
    assert [path.name for path in first] == [path.name for path in second]
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()


def test_the_terminal_table_shows_names_as_they_are(hostile: Results, results: Results) -> None:
    console = Console(width=200, record=True, quiet=True)
    with console.capture() as shown:
        console.quiet = False
        console.print(headline_table(hostile), headline_table(results))
    assert all(name in shown.get() for name in HOSTILE)
    assert "four" in shown.get()
    assert "knows the map" in shown.get()
