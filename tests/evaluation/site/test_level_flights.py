"""Boxes are the obstacles, corners are the route, setpoints keep their speed, and the page has the measured table."""

import importlib.util

import numpy as np
import pytest

from indoor_explorers.env import FREE, OCCUPIED
from indoor_explorers.env.grid.levels import Levels, plane_of
from indoor_explorers.env.search.any_angle import straightened
from indoor_explorers.evaluation.site.studies.level_flights import (
    BODIES,
    RESTS,
    Flight,
    boxes,
    corners,
    flight_table,
    in_free,
    progress,
    row_of,
    setpoints,
)
from tests.documents import SITE

PAGE = (SITE / "pages" / "levels.md").read_text("utf-8")
#: A route in metres: along, up, and back.
ROUTE = np.array([[0.25, 0.25, 0.25], [0.25, 0.25, 1.25], [0.75, 0.25, 1.25], [0.75, 0.25, 0.25]])
EMPTY = np.zeros((2, 1, 3), np.bool_)


def test_the_page_has_the_table():
    assert "\n".join(flight_table()) in PAGE


@pytest.mark.parametrize("share", [0.0, 0.2, 0.7, 1.0])
def test_boxes_cover_each_obstacle_once_and_nothing_else(share):
    occupied = np.random.default_rng(3).random((4, 5, 6)) < share
    count = np.zeros(occupied.shape, int)
    for (level, row, col), (top, down, right) in boxes(occupied):
        count[level:top, row:down, col:right] += 1
    np.testing.assert_array_equal(count, occupied)


def test_what_is_a_box_is_one():
    occupied = np.zeros((4, 5, 6), np.bool_)
    occupied[1:4, 2:4, 0:5] = True
    assert boxes(occupied).tolist() == [[[1, 2, 0], [4, 4, 5]]]


def test_corners_and_straight_lines_between_them_are_the_track():
    rng = np.random.default_rng(5)
    steps = np.concatenate((np.zeros((3, 3), int), np.eye(3, dtype=int), -np.eye(3, dtype=int)))
    for _ in range(20):
        track = np.cumsum(np.repeat(rng.permutation(steps), rng.integers(1, 4, len(steps)), axis=0), axis=0)
        found = [corners(track)[0]]
        for corner in corners(track)[1:]:
            count = np.abs(corner - found[-1]).sum()
            found += [found[-1] + (corner - found[-1]) * k // count for k in range(1, count + 1)]
        moved = track[np.r_[True, np.diff(track, axis=0).any(axis=1)]]
        np.testing.assert_array_equal(found, moved)
    assert corners(np.zeros((4, 3), int)).tolist() == [[0, 0, 0]]


def test_a_straightened_track_keeps_its_ways_up_and_down():
    levels = Levels(2, 3, 3)
    voxels = [(0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 2), (1, 1, 2), (1, 2, 2), (1, 2, 1)]
    cells = np.array([levels.cell(voxel) for voxel in voxels])
    truth = plane_of(np.full(tuple(levels), FREE, np.uint8), OCCUPIED)
    assert straightened(truth, cells).tolist() == [0, 3, 4, 6]


@pytest.mark.parametrize("length", [0.5, 3.0])
def test_setpoints_rest_at_corners_and_are_no_faster_than_their_speed(length):
    along = progress(length, 1.0, 1.0, 0.01)
    speed = np.diff(along, prepend=0.0) / 0.01
    assert along[-1] == pytest.approx(length)
    assert speed.max() == pytest.approx(min(1.0, np.sqrt(length)), abs=0.01)
    assert np.abs(np.diff(speed, prepend=0.0, append=0.0)).max() <= 0.011
    assert len(along) == pytest.approx(100 * (2 * np.sqrt(length) if length < 1.0 else length + 1.0), abs=1)


@pytest.mark.parametrize("acceleration", RESTS.values())
def test_setpoints_pass_every_corner(acceleration):
    legs, due, _ = (np.array(column) for column in zip(*setpoints(ROUTE, 0.5, acceleration, 0.01), strict=True))
    assert (np.diff(legs) >= 0).all()
    for leg, end in enumerate(ROUTE[1:]):
        np.testing.assert_allclose(due[legs == leg][-1], end)
    if acceleration is None:
        assert len(due) == 500


def test_the_measures_of_a_track():
    due = np.linspace(ROUTE[0], ROUTE[1], 30)
    flight = Flight(1.0, True, np.zeros(30, int), due + (0.0, 0.1, 0.0), due, np.arange(30) % 10 == 0)
    row = row_of(flight, ROUTE, EMPTY, 0.5)
    assert [row[f"{name}_m"] for name in ("late_mean", "late_max", "beside_95")] == pytest.approx([0.1] * 3)
    assert (row["contacts"], row["contact_s"]) == (3, 0.1)
    assert (row["free_body"], row["free_large"]) == (1.0, 0.0)


def test_a_body_is_in_free_voxels_until_it_is_over_the_border_of_one():
    places = np.array([[0.25, 0.25, 0.25], [0.25, 0.25, 0.44], [0.25, 0.25, 0.46], [0.25, 0.25, 0.75]])
    occupied = np.array([[[False, True, False]]])
    assert in_free(occupied, 0.5, places, BODIES["body"]) == 0.5


@pytest.mark.slow
@pytest.mark.filterwarnings("default")
@pytest.mark.skipif(
    importlib.util.find_spec("PyFlyt") is None, reason="needs PyFlyt, a tool beside the tests: pip install PyFlyt"
)
def test_a_route_is_flown_in_pyflyt_and_walls_are_solid():
    from indoor_explorers.evaluation.site.studies.level_flights_pyflyt import flown

    open_room = np.zeros((6, 6, 6), np.bool_)
    route = np.array([[1.5, 1.5, 0.75], [1.5, 1.5, 2.25]])
    flight = flown(route, open_room, 0.5, 0.5, 1.0, seed=0)
    assert flight.arrived
    assert not flight.touching.any()
    assert row_of(flight, route, open_room, 0.5)["beside_max_m"] < 0.5
    walled = open_room.copy()
    walled[:, :, 3] = True
    flight = flown(route, walled, 0.5, 0.5, 1.0, seed=0)
    assert flight.touching.any()
    assert not flight.arrived
    assert (flight.position[:, 2] < 1.5).all()
