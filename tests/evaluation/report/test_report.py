from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console, RenderableType

from indoor_explorers.env import Scenario
from indoor_explorers.env.maps.sources import ThesisMaps
from indoor_explorers.env.scenarios.parts import Lidar, Radio
from indoor_explorers.evaluation.analysis.tables.headline_table import headline_table
from indoor_explorers.evaluation.analysis.tables.policy_names import DAGGER, DOUBLE_DAGGER, SECTION
from indoor_explorers.evaluation.analysis.tables.ratio_table import ratio_lines
from indoor_explorers.evaluation.drawing import print_style
from indoor_explorers.evaluation.exports.figures import write_figures
from indoor_explorers.evaluation.exports.markdown import markdown_ratios
from indoor_explorers.evaluation.harness.results.ratios import Ratios
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report import write_report
from indoor_explorers.evaluation.report.page import render
from tests.evaluation.reports import HOSTILE, Page, Wander, results_of, texts_of


def test_a_page_loads_nothing(page: Page) -> None:
    for tag, about in page.tags:
        assert not {"src", "srcset", "action", "background", "poster"} & about.keys(), (tag, about)
        assert tag not in ("link", "iframe", "object", "embed", "img", "base", "form")
        assert str(about.get("href", "#")).startswith("#")
    policy = next(about["content"] for _, about in page.tags if about.get("http-equiv") == "Content-Security-Policy")
    assert "default-src 'none'" in str(policy)
    assert "http" not in str(policy)


def test_no_chart_offers_to_upload_itself(page: Page) -> None:
    config = re.search(r"Plotly\.setPlotConfig\((\{.*?\})\)", "".join(text for _, text in page.scripts[-8:]))
    assert config
    assert "showSendToCloud: false" in config[1]


@pytest.mark.slow
def test_equal_results_give_equal_bytes(results: Results, tmp_path: Path) -> None:
    write_report(results, tmp_path / "new" / "a.html")
    again = Results(results.policies, results.scenarios, results.runs, list(results.records))
    write_report(again, tmp_path / "b.html")
    assert (tmp_path / "new" / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_failures_are_told_with_their_cause(page: Page) -> None:
    assert "ValueError: lost <the> way" in page.text
    assert "knows the map" in page.text
    assert "share of the free cells reachable from the spawns" in page.text
    assert "indoor-explorers compare --out a" in page.text


def test_hostile_names_are_only_text(hostile: Results) -> None:
    page = Page(render(hostile, title="<script>alert(3)</script>"))
    executable = [text for about, text in page.scripts if about.get("type") != "application/json"]
    assert len(executable) == 9
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
    curves = page.data("chart-data")[0]["policies"][0]["curves"]["steps"]["team"]
    assert len(curves["each"]) == 3
    assert "low" not in curves


def test_enough_episodes_get_intervals(page: Page) -> None:
    assert re.search(r"\[\d+\.\d+, \d", page.text)
    assert page.data("chart-data")[1]["who"] == ["team", "worst", "mean"]


def test_results_without_episodes_still_make_a_page(results: Results, tmp_path: Path) -> None:
    empty = Results(results.policies, results.scenarios, [], [])
    assert "No episode of this scenario" in render(empty)
    assert write_figures(empty, tmp_path) == []
    assert "no scenario" in render(Results({}, {}, [], []))


@pytest.mark.slow
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


def test_figures_are_drawn_whatever_the_names(
    hostile: Results, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(print_style, "FORMATS", {"svg": print_style.FORMATS["svg"]})  # all of them in make test-all
    assert {path.suffix for path in write_figures(hostile, tmp_path)} == {".svg"}


@pytest.mark.slow
def test_figures_are_deterministic(hostile: Results, tmp_path: Path) -> None:
    first, second = write_figures(hostile, tmp_path / "a"), write_figures(hostile, tmp_path / "b")
    assert {path.suffix for path in first} == {".svg", ".png", ".pdf"}
    assert [path.name for path in first] == [path.name for path in second]
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()


@pytest.fixture(scope="module")
def plain(results: Results) -> str:
    """The page of results in which nothing is marked."""
    return render(results)


@pytest.mark.parametrize(
    ("facts", "name", "texts", "pages"),
    [
        (
            {"uses_generator": True},
            "broken",
            [f"broken {DAGGER}", f"{DAGGER} reads the settings of the maps' generator"],
            ["knows the generator</span>", "generator that draws the maps, never the map: broken."],
        ),
        (
            {"failed_check": "map of the seed: knows it [/]; to fix it, forget it"},
            "broken",
            [
                f"broken {DOUBLE_DAGGER}",
                f"{DOUBLE_DAGGER} broken failed the check map of the seed: knows it [/]; to fix it, forget it.",
            ],
            ["failed a check</span>", "to fix it, forget it. It is not ranked: its figures may"],
        ),
        (
            {"batched": True},
            "straight",
            ["s (batch share)", "Batch share: the policy decides"],
            ["batch times</span>", "whose decision times are shares of a batch: straight."],
        ),
    ],
)
def test_policies_that_know_more_failed_or_share_times_are_marked(
    results: Results, plain: str, facts: dict[str, Any], name: str, texts: list[str], pages: list[str]
) -> None:
    policies = results.policies | {name: results.policies[name] | facts}
    marked = Results(policies, results.scenarios, results.runs, list(results.records))
    for found, page, expected in ((results, plain, False), (marked, render(marked), True)):
        ratios = Ratios.of(found)
        shown = texts_of(found)
        if "batched" not in facts:  # ratios have no decision times
            shown.append(printed(*ratio_lines(ratios)))
        if "uses_generator" in facts:
            shown.append(markdown_ratios(ratios))
        for text in (each.replace(r"$\dagger$", DAGGER).replace(r"$\ddagger$", DOUBLE_DAGGER) for each in shown):
            plainly = " ".join(text.replace("\\", "").split())
            assert [words in plainly for words in texts] == [expected] * len(texts)
        assert [words in page for words in pages] == [expected] * len(pages)


def test_policies_from_outside_that_were_not_isolated_are_marked(results: Results) -> None:
    name = "broken"
    for isolated, kind, expected in (
        (False, "out:Side", True),
        (True, "out:Side", False),
        (False, "indoor_explorers.planners.x:Y", False),
    ):
        policies = results.policies | {name: results.policies[name] | {"isolated": isolated, "class": kind}}
        found = Results(policies, results.scenarios, results.runs, list(results.records))
        texts = [*texts_of(found), printed(*ratio_lines(Ratios.of(found)))]
        for text in (each.replace(r"\S", SECTION) for each in texts):
            assert (f"{name} {SECTION}" in text) == expected
            assert (f"{SECTION} flew in the process that has the true map" in " ".join(text.split())) == expected
        page = render(found)
        assert ("not isolated</span>" in page) == expected
        assert (f"where it could have read it: {name}." in page) == expected
        assert ("flew isolated</small>" in page) == isolated


def printed(*parts: RenderableType) -> str:
    console = Console(width=200, markup=False)
    with console.capture() as shown:
        console.print(*parts)
    return shown.get()


def test_the_terminal_table_shows_names_as_they_are(hostile: Results, results: Results) -> None:
    console = Console(width=200, record=True, quiet=True)
    with console.capture() as shown:
        console.quiet = False
        console.print(headline_table(hostile), headline_table(results))
    assert all(name in shown.get() for name in HOSTILE)
    assert "four" in shown.get()
    assert "knows the map" in shown.get()
