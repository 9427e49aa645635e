"""Rays against the exact lidar, whose cells are tested against rational arithmetic."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from indoor_explorers.env import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.sensing.lidar import scan
from indoor_explorers.env.sensing.rays import first_hits
from tests.env.sensing.test_lidar import places


@settings(max_examples=300, deadline=None)
@given(places(side=14), st.sampled_from([1.0, 2.5, 4.0, 9.0]))
def test_a_ray_reaches_the_centres_that_the_lidar_sees_and_no_others(place, lidar_range):
    truth, cell = place
    free = np.argwhere(truth == FREE)
    away = free - np.array(cell)
    apart = np.hypot(*away.T)
    kept = (apart > 0) & (apart <= lidar_range)
    hits = first_hits(truth, cell, lidar_range, np.arctan2(-away[kept, 0], away[kept, 1]))
    seen = scan(truth, cell, lidar_range)[tuple(free[kept].T)] != UNKNOWN
    np.testing.assert_array_equal(hits > apart[kept], seen)


@settings(max_examples=200, deadline=None)
@given(places(side=14), st.floats(-math.pi, math.pi))
@example((np.array([[FREE]], np.uint8), (0, 0)), 2e-309)  # almost along the columns
def test_a_hit_is_on_the_border_of_an_obstacle(place, angle):
    truth, cell = place
    (hit,) = first_hits(truth, cell, 30.0, np.array([angle]))
    if math.isinf(hit):
        return
    row, col = cell[0] - hit * math.sin(angle), cell[1] + hit * math.cos(angle)
    obstacles = np.argwhere(truth == OCCUPIED)
    beside = np.abs(obstacles - np.array([row, col])).max(axis=1)
    assert beside.min() == pytest.approx(0.5, abs=1e-6)


def test_walls_around_a_cell():
    truth = np.full((3, 5), OCCUPIED, np.uint8)
    truth[1, 1:4] = FREE
    angles = np.radians([0, 90, 180, 270, 45])
    np.testing.assert_allclose(first_hits(truth, (1, 1), 9.0, angles), [2.5, 0.5, 0.5, 0.5, math.sqrt(0.5)])
    assert np.isinf(first_hits(truth, (1, 1), 2.0, angles[:1])).all()
    assert np.isinf(first_hits(truth[:, 1:4], (1, 0), 9.0, angles[[0, 2]])).all()  # nothing is off the map
