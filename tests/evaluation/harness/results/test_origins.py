"""Kind and source of maps: what a store keeps of them, and ratios on the maps of each."""

from __future__ import annotations

import csv
import shutil
import sqlite3
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.sources import FileMaps, MazeMaps
from indoor_explorers.env.scenarios.suites import catalogue
from indoor_explorers.evaluation.analysis.tables.origin_table import origin_tables
from indoor_explorers.evaluation.cli.command import make_console
from indoor_explorers.evaluation.cli.commands.compare import print_ratios
from indoor_explorers.evaluation.driver import fly_missing
from indoor_explorers.evaluation.exports import write_exports
from indoor_explorers.evaluation.exports.markdown import markdown_ratios
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.results.combine import combined
from indoor_explorers.evaluation.harness.results.origin_ratios import ratios_by_origin
from indoor_explorers.evaluation.harness.results.origins import Origin, maps_by_origin
from indoor_explorers.evaluation.harness.results.ratios import Ratios
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.page import render
from tests.evaluation.report.records import made_up, results_of, room

HALL, MAZE = Origin("halls", "hall"), Origin("mazes", "maze")


def asked(policies=("random",), **more):
    return ComparisonRequest.of(policies=policies, episodes=1, workers=0, settings={"budget": 8}, **more)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A hall in one folder, a hall and a maze in another."""
    folder = tmp_path_factory.mktemp("maps")
    hall, maze = np.zeros((20, 30), np.uint8), MazeMaps(height=41, width=41).floorplan(0, 0).truth != 1
    for name, walls in (("halls/wide", hall), ("mixed/long", hall[:15]), ("mixed/maze", maze)):
        path = folder / f"{name}.npy"
        path.parent.mkdir(exist_ok=True)
        np.save(path, walls)
    return sorted(map(str, folder.glob("*/*.npy")))


@pytest.fixture(scope="module")
def flown(files, tmp_path_factory):
    out = tmp_path_factory.mktemp("flown")
    request = asked(maps=files)
    fly_missing(plan(request), out, request)
    return out


@pytest.fixture
def old(flown, tmp_path):
    """The same results in a store of an older version."""
    copy = shutil.copytree(flown, tmp_path / "old")
    with closing(sqlite3.connect(copy / "results.db")) as db, db:
        db.execute("DROP TABLE origin")
    return copy


def test_the_source_of_files_is_their_folder(flown):
    results = Results.load(flown)
    found = {record.floorplan.name: results.origins[record.floorplan.digest] for record in results.records}
    assert found == {"wide": HALL, "long": Origin("mixed", "hall"), "maze": Origin("mixed", "maze")}


def test_the_source_of_generated_maps_is_the_generator(tmp_path):
    request = asked(scenario=("maze", "office-base-2"))
    fly_missing(plan(request), tmp_path, request)
    assert {origin.source for origin in Results.load(tmp_path).origins.values()} == {"maze", "office"}


def test_the_source_of_a_suites_map_is_its_repository(files, monkeypatch):
    maps = FileMaps(paths=tuple(files))
    floorplan = maps.floorplan(0, 0)
    assert catalogue.source_of(maps, 0, floorplan) == "halls"
    monkeypatch.setattr(catalogue, "repositories", lambda: {floorplan.digest: "amrl_maps"})
    assert catalogue.source_of(maps, 0, floorplan) == "amrl_maps"
    assert catalogue.source_of(maps, 2, maps.floorplan(2, 0)) == "mixed"


def test_every_map_of_the_suites_has_a_repository():
    digests = catalogue.buildings().keys()
    known = {"amrl_maps", "generativeCMLgraphs", "declutter-reconstruct", "DRL_robot_exploration", "IR2", "DARE"}
    assert catalogue.repositories().keys() == digests
    assert known < set(catalogue.repositories().values())


def test_an_older_store_is_read_as_before_and_shows_no_such_table(old, flown, tmp_path):
    before = (old / "results.db").read_bytes()
    results = Results.load(old)
    assert results.origins == {}
    assert (old / "results.db").read_bytes() == before
    assert ratios_by_origin(Ratios.of(results)) == []
    assert render(results) == render(replace(Results.load(flown), origins={}))


def test_an_older_store_that_is_flown_on_learns_the_origins(old, files):
    request = asked(("random", "frontier-nearest"), maps=files)
    fly_missing(plan(request), old, request)
    assert len(Results.load(old).origins) == 3


def test_a_damaged_origin_is_not_believed_and_made_again(old, flown, files):
    shutil.copy(flown / "results.db", old / "results.db")
    with closing(sqlite3.connect(old / "results.db")) as db, db:
        db.execute("UPDATE origin SET kind = 'home' WHERE kind = 'maze'")
    assert sorted(Results.load(old).origins.values()) == [HALL, ("mixed", "hall")]
    request = asked(("random", "frontier-nearest"), maps=files)
    fly_missing(plan(request), old, request)
    assert Results.load(old).origins == Results.load(flown).origins


def test_combined_results_have_the_origins_of_both(files, tmp_path, flown):
    request = asked(("frontier-nearest",), maps=files)
    fly_missing(plan(request), tmp_path, request)
    both = combined([Results.load(flown), replace(Results.load(tmp_path), origins={})])
    assert both.origins == Results.load(flown).origins


def test_maps_are_grouped_only_by_what_differs():
    origins = {"a": HALL, "b": Origin("mazes", "hall"), "c": MAZE}
    assert maps_by_origin(origins, ["a", "b"]) == {"source: halls": {"a"}, "source: mazes": {"b"}}
    assert maps_by_origin(origins, ["b", "c"]) == {"kind: hall": {"b"}, "kind: maze": {"c"}}
    assert list(maps_by_origin(origins, "abc")) == ["kind: hall", "kind: maze", "source: halls", "source: mazes"]
    assert maps_by_origin(origins, ["a"]) == maps_by_origin(origins, []) == {}
    assert maps_by_origin(origins, ["a", "c", "unknown"]) == {}


TIMES = {
    "frontier-nearest": {"near": [20, 40, 10, 50, 30, 25, 60, 70], "far": [80, 60, 90, 90, 70, 85, 60, 95]},
    "quick": {"near": [10, 30, 10, 25, 20, 20, 66, 84], "far": [60, 50, 75, 80, 70, 60, 72, 95]},
}
#: Maps 0 to 5 are halls, 5 and 6 of the second source.
KINDS = [HALL, HALL, HALL, HALL, HALL, Origin("mazes", "hall"), MAZE, MAZE]


def numbered(index):
    free = np.ones((8, 8), np.bool_)
    free[0, : index + 1] = False
    return Floorplan.from_free(free, f"map-{index}")


@pytest.fixture
def results():
    records = [
        replace(made_up(policy, Task(name, index, 0), late), floorplan=numbered(index))
        for policy, scenarios in TIMES.items()
        for name, times in scenarios.items()
        for index, late in enumerate(times)
    ]
    origins = {numbered(index).digest: origin for index, origin in enumerate(KINDS)}
    return replace(results_of(records, room("near"), room("far")), origins=origins)


def ratio(places):
    found = [np.divide(TIMES["quick"][name], TIMES["frontier-nearest"][name])[places] for name in ("near", "far")]
    return float(np.mean(found))


def test_ratios_by_kind_and_source_are_those_of_a_plain_computation(results):
    table = next(each for each in origin_tables(ratios_by_origin(Ratios.of(results))) if each.key.startswith("t99"))
    assert [column.title for column in table.columns] == ["maps of", "maps", "quick"]
    places = {
        "kind: hall": slice(0, 6),
        "kind: maze": slice(6, 8),
        "source: halls": slice(0, 5),
        "source: mazes": slice(5, 8),
    }
    assert [row.name for row in table.rows] == list(places)
    for name, (maps, figure), _ in table.rows:
        assert int(maps.text) == len(KINDS[places[name]])
        assert figure.value == pytest.approx(ratio(places[name]))
        assert ("[" in figure.detail) == (len(KINDS[places[name]]) >= 5)  # fewer tasks have no interval
    assert [row.cells[1].shade > 0 for row in table.rows] == [True, False, True, False]


def test_maps_of_one_building_are_told_and_count_as_one(results, monkeypatch):
    known = {numbered(index).digest: "suite: A" for index in range(4)}
    for module in ("evaluation.harness.results.map_labels", "env.scenarios.suites.catalogue"):
        monkeypatch.setattr(f"indoor_explorers.{module}.buildings", lambda: known)
    table = origin_tables(ratios_by_origin(Ratios.of(results)))[0]
    assert table.rows[0].cells[0].line == "6 in 3 buildings"
    assert table.rows[1].cells[0].line == "2"


def test_page_markdown_terminal_and_csv_show_the_same_figures(results, tmp_path):
    ratios = Ratios.of(results)
    (table, *_) = origin_tables(ratios_by_origin(ratios))
    page, text = render(results), markdown_ratios(ratios)
    write_exports(results, tmp_path)
    with (tmp_path / "tables" / "ratios_by_origin.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if (row["metric"], row["scenario"]) == ("t99", "all scenarios")]
    for row, written in zip(table.rows, rows, strict=True):
        assert row.name == written["maps_of"]
        assert row.cells[1].value == pytest.approx(float(written["mean_of_ratios"]), rel=1e-5)
        assert f'<th scope="row">{row.name}</th>' in page
        assert f'<data value="{row.cells[1].value}">{row.cells[1].text}</data>' in page
        assert f"| {row.name} | {row.cells[0].line} | {row.cells[1].line} |" in text


def test_the_terminal_shows_them_where_ratios_are_asked_for(results, capsys):
    print_ratios(results, ["frontier-nearest"], make_console())
    assert "kind: maze" in capsys.readouterr().out


def test_one_kind_of_one_source_has_no_table(results, tmp_path):
    alike = replace(results, origins=dict.fromkeys(results.origins, HALL))
    assert render(alike) == render(replace(results, origins={}))
    write_exports(alike, tmp_path)
    assert not (tmp_path / "tables" / "ratios_by_origin.csv").exists()
    assert "kind" not in markdown_ratios(Ratios.of(alike))
