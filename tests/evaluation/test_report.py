from __future__ import annotations

import base64
import re
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from indoor_explorers.env import Scenario
from indoor_explorers.env.grid import OCCUPIED, UNREACHABLE, distance_field
from indoor_explorers.env.maps.sources import ThesisMaps
from indoor_explorers.env.scenario import Lidar, Radio
from indoor_explorers.evaluation.experiment import Task
from indoor_explorers.evaluation.record import Record
from indoor_explorers.evaluation.report import headline_table, write_figures, write_report
from indoor_explorers.evaluation.report.flight import known_from, pack_flight
from indoor_explorers.evaluation.report.packing import packed, runs, unfolded, unpacked
from indoor_explorers.evaluation.report.page import render
from indoor_explorers.evaluation.results import Results

from .reports import HOSTILE, Page, Wander, results_of


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


def test_failures_are_told_with_their_cause(page: Page) -> None:
    assert "ValueError: lost <the> way" in page.text
    assert "knows the map" in page.text
    assert "share of the free cells reachable from the spawns" in page.text
    assert "indoor-explorers compare --out a" in page.text


def test_hostile_names_are_only_text(hostile: Results) -> None:
    page = Page(render(hostile, title="<script>alert(3)</script>"))
    executable = [text for about, text in page.scripts if about.get("type") != "application/json"]
    assert len(executable) == 7
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


def _replayed(record: Record, stream: bytes, frames: int) -> tuple[np.ndarray, list[int], np.ndarray]:
    """Unpack a flight as the page does: the known cells, covered counts and last cells."""
    numbers = unpacked(stream)
    known = np.zeros(record.floorplan.truth.size, bool)
    covered, cells = [0], np.zeros(2 * record.team, int)
    for _ in range(frames):
        cells += [unfolded(next(numbers)) for _ in range(len(cells))]
        covered.append(covered[-1] + next(numbers))
        place = 0
        for _ in range(next(numbers)):
            place += next(numbers)
            length = next(numbers) + 1
            known[place : place + length] = True
            place += length
    assert next(numbers, None) is None
    return known, covered[1:], cells.reshape(-1, 2)


@pytest.mark.parametrize("stride", [1, 7])
def test_replays_cover_what_the_records_say(results: Results, stride: int) -> None:
    for record in results.records:
        known = known_from(record, 3.0)
        shown = [*range(0, record.steps, stride), record.steps]
        spawn = (int(record.cells[0, 0, 0]), int(record.cells[0, 0, 1]))
        counted = (distance_field(record.floorplan.truth, spawn) < UNREACHABLE).ravel()
        assert [int((counted & (known >= 0) & (known <= s)).sum()) for s in shown] == record.covered[shown, 0].tolist()
        final, covered, cells = _replayed(record, pack_flight(record, known, stride), len(shown))
        assert (final == (known >= 0)).all()
        assert covered == record.covered[shown, 0].tolist()
        assert (cells == record.cells[-1]).all()


def test_embedded_walls_are_those_of_the_map(results: Results, page: Page) -> None:
    replay = page.data("replay-data")[0]
    assert replay["range"] == 3.0
    for episode in replay["episodes"]:
        walls = np.unpackbits(np.frombuffer(base64.b64decode(episode["walls"]), np.uint8))[:256].reshape(16, 16)
        truth = next(r for r in results.records if r.task == Task("rooms", 0, episode["seed"])).floorplan.truth
        assert (walls == (truth == OCCUPIED)).all()
    assert replay["episodes"][0]["label"] == "median"
    assert len(replay["episodes"][0]["flights"]) == 3


def test_packing() -> None:
    numbers = [0, 1, 127, 128, 300, 2**31]
    assert list(unpacked(packed(numbers))) == numbers
    assert runs(np.array([0, 1, 5, 6, 7, 20])) == [0, 1, 3, 2, 12, 0]
    assert runs(np.array([], np.int64)) == []


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
    assert episode["stride"] > 1
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
