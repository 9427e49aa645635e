from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from PIL import Image

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.drawing.palette import policy_styles
from indoor_explorers.evaluation.drawing.print_style import COLUMN, PAGE, plain, print_style, save
from indoor_explorers.evaluation.exports.figures.panel_figures import scenario_figures, sweep_figures
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.page import render
from tests.evaluation.report.records import flown, made_up, results_of, room
from tests.evaluation.reports import Page

HOSTILE = "a\"b', </script><script>alert('x')</script> 🚁 $x_1$"


@pytest.fixture(scope="module")
def swept() -> Results:
    """Two policies at three teams and three radios, five seeds."""
    scenarios = [
        room("solo"),
        room("deaf", 2),
        room("near", 2, **{"radio.model": "disc", "radio.range": 2.0}),
        room("far", 2, **{"radio.model": "unlimited"}),
    ]
    speeds = {"solo": 40.0, "deaf": 30.0, "near": 25.0, "far": 20.0}
    records = [
        made_up(
            policy, Task(each.name, 0, seed), speeds[each.name] + seed + extra, team=each.team, auc=0.9, overlap=0.5
        )
        for each in scenarios
        for policy, extra in ((HOSTILE, 0), ("plain", 5))
        for seed in range(5)
    ]
    return results_of(records, *scenarios)


def test_cells_are_buttons_that_name_the_episode(swept: Results) -> None:
    page = Page(render(swept))
    links = [(tag, str(about["data-replay"])) for tag, about in page.tags if "data-replay" in about]
    assert {tag for tag, _ in links} == {"button"}
    read = [json.loads(link) for _, link in links]
    assert {each["policy"] for each in read} == {HOSTILE, "plain"}
    assert {tuple(each["task"]) for each in read} == {(0, seed) for seed in range(5)}


def test_hostile_names_are_only_text(swept: Results) -> None:
    text = render(swept)
    page = Page(text)
    assert "<script>alert(" not in text
    assert all({series["name"] for series in plot["series"]} <= {HOSTILE, "plain"} for plot in page.data("plot-data-"))
    assert all(page.data(f"plot-data-{name}") for name in ("s1-profile", "s1-pareto", "radio-1-1", "teams-1-3"))


def test_the_numbers_of_a_sweep_are_those_of_the_records(swept: Results) -> None:
    page = Page(render(swept))
    (radio,), (teams,) = page.data("plot-data-radio-1-2"), page.data("plot-data-teams-1-2")
    t99 = next(s for s in radio["series"] if s["name"] == "plain")
    assert t99["y"] == [37, 32, 27]
    assert all(low < mean < high for low, mean, high in zip(t99["low"], t99["y"], t99["high"], strict=True))
    assert [text for _, text in radio["x"]["ticks"]] == ["none", "2", "unlimited"]
    speedup = next(s for s in teams["series"] if s["name"] == "plain")
    assert speedup["y"] == pytest.approx([1, 47 / 37], rel=1e-4)


def test_sweeps_are_absent_where_there_are_none() -> None:
    page = Page(render(flown({"a": [10, 20], "b": [12, 30]})))
    assert not {"radio", "teams", "sweeps"} & {about.get("id") for _, about in page.tags}
    assert not [about for _, about in page.tags if about.get("href") in ("#radio", "#teams", "#sweeps")]


def test_a_sweep_of_a_setting_has_a_section_and_a_figure() -> None:
    rooms = [room(f"range {reach}", **{"lidar.range": reach}) for reach in (2, 3, 5)]
    times = {"range 2": 40, "range 3": 30, "range 5": 20}
    records = [made_up("a", Task(name, 0, seed), late + seed) for name, late in times.items() for seed in range(5)]
    results = results_of(records, *rooms)
    page = Page(render(results))
    assert [about for _, about in page.tags if about.get("href") == "#sweeps"]
    (t99,) = page.data("plot-data-setting-1-2")[0]["series"]
    assert (t99["x"], t99["y"]) == ([2, 3, 5], [42, 32, 22])
    with print_style():
        assert [name for name, _ in sweep_figures(results, policy_styles(results.policies))] == ["settings"]


def test_a_single_policy_gets_no_comparison() -> None:
    text = re.sub(r"<(script|style).*?</\1>", "", render(flown({"a": [10, 20]})), flags=re.S)
    for heading in ("Who beats whom", "T99 by seed", "Probability of improvement", "Performance profile"):
        assert heading not in text


def test_few_episodes_get_no_interval_anywhere() -> None:
    (pareto,) = Page(render(flown({"a": [10, 20], "b": [12, 30]}))).data("plot-data-s1-pareto")
    assert all("low" not in series and len(series["dots"]) == 2 for series in pareto["series"])


@pytest.mark.slow
def test_figures_for_print_are_those_with_content_and_deterministic(swept: Results, tmp_path: Path) -> None:
    few = {name: swept.scenarios[name] for name in ("solo", "deaf")}
    part = Results(swept.policies, few, [], [record for record in swept.records if record.task.scenario in few])
    comparison, styles = Comparison(part, "solo"), policy_styles(swept.policies)
    written = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        with print_style():
            figures = [*scenario_figures(comparison, styles), *sweep_figures(part, styles)]
            assert [name for name, _ in figures] == ["profile", "pareto", "rank-plot", "teams-01"]
            assert {figure.get_figwidth() for _, figure in figures} == {COLUMN, PAGE}
            written.append([path.read_bytes() for name, figure in figures for path in save(figure, folder, name)])
    assert written[0] == written[1]


def test_a_figure_is_exactly_as_wide_as_a_column_or_two(swept: Results, tmp_path: Path) -> None:
    comparison, styles = Comparison(swept, "solo"), policy_styles(swept.policies)
    with print_style():
        for name, figure in scenario_figures(comparison, styles):
            shown = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
            assert shown == ([plain(policy) for policy in swept.policies] if shown else [])
            png = next(path for path in save(figure, tmp_path, name) if path.suffix == ".png")
            with Image.open(png) as picture:
                assert picture.width == 200 * (PAGE if name == "rank-plot" else COLUMN)
