"""Comparisons of maps: pockets of a flight, distances by hand, and the command."""

import numpy as np
import pytest

from indoor_explorers.env import Scenario, World, scenario
from indoor_explorers.env.grid.cells import FREE, UNKNOWN
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.sources import RoomsMaps
from indoor_explorers.env.maps.statistics import Statistic
from indoor_explorers.evaluation.cli import main
from indoor_explorers.evaluation.studies.maps.comparison import (
    COMPARED,
    distance,
    maps_of,
    measured,
    pooled,
    sampled_frontiers,
)

SIZE, SHARE = Statistic("size", "cells", True), Statistic("share", "", False)


def arrays(*values):
    return [np.array(each, np.float64) for each in values]


def test_a_flight_looks_at_all_that_is_unknown_at_first_and_then_now_and_again():
    task = Scenario(map=RoomsMaps(height=24, width=24))
    plan = task.map.floorplan(0, 3)
    found = sampled_frontiers(plan, task, 3)
    assert len(found.pockets) == found.clusters.sum()
    world = World(task.with_settings({"spawn": "random"}))
    world.begin(0, 3, floorplan=plan)
    unknown = plan.main_part & (world.state.belief[0, 0] == UNKNOWN)
    assert found.pockets[: int(found.clusters[0])].sum() == unknown.sum()
    assert len(found.clusters) > 3
    assert found.pockets[-int(found.clusters[-1]) :].sum() < unknown.sum() / 2


def test_every_map_weighs_the_same_and_sizes_are_compared_by_ratios():
    sample = pooled(SIZE, arrays([1.0, 1.0, 1.0], [], [np.e]))
    assert sample.values.tolist() == [0.0, 0.0, 0.0, 1.0]
    assert sample.weights == pytest.approx([1 / 6, 1 / 6, 1 / 6, 1 / 2])
    assert sample.spread == pytest.approx(0.5)
    assert sample.quantiles([0.5, 0.6]).tolist() == [0.0, 1.0]
    assert pooled(SIZE, arrays([], [])) is None


def test_the_distance_is_in_standard_deviations_of_the_given_maps():
    given = pooled(SHARE, arrays([0.0], [2.0]))
    assert distance(given, given) == 0.0
    assert distance(given, pooled(SHARE, arrays([3.0], [5.0]))) == pytest.approx(3.0)
    assert distance(given, pooled(SHARE, arrays([1.0]))) == pytest.approx(1.0)
    constant = pooled(SHARE, arrays([1.0]))
    assert distance(constant, constant) == 0.0
    assert distance(constant, given) == np.inf


def test_maps_of_a_generator_come_from_seeds_and_those_of_files_once():
    rooms = scenario("small-rooms")
    assert [plan.digest for plan in maps_of(rooms, 2, 5)] == [rooms.map.floorplan(0, seed).digest for seed in (5, 6)]
    assert len(maps_of(scenario("office"), 7, 0)) == 1
    found = measured("rooms", maps_of(rooms, 2, 5), rooms, 0)
    assert found.maps == 2
    assert set(found.samples) <= {kind.name for kind in COMPARED}
    assert len(found.samples["floor"].values) == 2


@pytest.fixture
def rooms_file(tmp_path):
    free = RoomsMaps(height=24, width=24).floorplan(0, 1)
    assert isinstance(free, Floorplan)
    np.save(tmp_path / "a.npy", (free.truth != FREE).astype(np.uint8))
    return tmp_path / "a.npy"


def printed(capsys, *words):
    status = main([str(word) for word in words])
    out, errors = capsys.readouterr()
    return status, out, errors


def test_the_command_prints_a_table_and_draws_a_figure(capsys, rooms_file, tmp_path):
    words = ("maps", rooms_file, "--compare", "small-rooms", "--samples", "2", "--figures", tmp_path / "drawn")
    status, out, errors = printed(capsys, *words)
    assert (status, errors) == (0, "")
    for word in ("small-rooms (2)", "dead ends", "pocket", "mean", "maps.svg"):
        assert word in out
    assert {path.suffix for path in (tmp_path / "drawn").iterdir()} == {".svg", ".png"}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--compare", "floors"], "expected the paths of map files with --compare"),
        (["a.npy", "--compare", "flors"], "did you mean 'floors'"),
        (["a.npy", "--figures", "out"], "expected --compare with --samples and --figures"),
        (["a.npy", "--compare", "floors", "--samples", "0"], "at least 1"),
    ],
)
def test_what_cannot_be_compared_is_said_in_one_line(capsys, words, message):
    status, out, errors = printed(capsys, "maps", *words)
    assert (status, out) == (2, "")
    assert message in errors
    assert errors.count("\n") == 1
