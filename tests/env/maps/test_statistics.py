"""Statistics of maps: exact on floors drawn by hand, the same for turned and padded ones."""

import numpy as np
import pytest

from indoor_explorers.env.maps.sources import FloorsMaps
from indoor_explorers.env.maps.statistics import (
    STATISTICS,
    cut_into_parts,
    furniture_share,
    local_widths,
    map_statistics,
    straight_share,
)


def floor(text):
    return np.array([[char == "." for char in line] for line in text.split()])


TWO_ROOMS = """
###############
#......#......#
#......#......#
#......#......#
#.............#
#......#......#
#......#......#
###############
"""
TWO_DOORS = """
###############
#......#......#
#.............#
#......#......#
#......#......#
#.............#
#......#......#
###############
"""
CORRIDOR = """
#################
#......##....####
#......##....####
#......##....####
#......##....####
####.######..####
#...............#
#...............#
#################
"""


def cut(text, passage=3):
    free = floor(text)
    return cut_into_parts(free, local_widths(free), passage)


def test_rooms_are_cut_apart_at_doors():
    parts = cut(TWO_ROOMS)
    assert parts.cells.tolist() == [36, 36]
    assert parts.width.tolist() == [6, 6]
    assert parts.passages.tolist() == [1]
    assert parts.loops == 0
    assert parts.dead_ends.tolist() == [True, True]


def test_a_second_door_makes_a_loop():
    parts = cut(TWO_DOORS)
    assert parts.passages.tolist() == [1, 1]
    assert parts.loops == 1
    assert not parts.dead_ends.any()


def test_a_narrow_corridor_is_a_part_and_its_doors_have_their_width():
    parts = cut(CORRIDOR)
    assert sorted(parts.cells.tolist()) == [16, 24, 30 + 3]
    assert sorted(parts.passages.tolist()) == [1, 2]
    assert parts.loops == 0
    assert parts.dead_ends.sum() == 2


def test_an_alcove_belongs_to_its_room_however_long_it_is():
    free = np.zeros((20, 30), np.bool_)
    free[5:15, 2:28] = True
    free[3:5, 4:8] = True
    free[15:17, 3:27] = True
    parts = cut_into_parts(free, local_widths(free), 3)
    assert parts.cells.tolist() == [free.sum()]
    assert len(parts.passages) == parts.loops == 0


def test_a_pillar_makes_no_loop_and_is_furniture():
    free = np.pad(np.ones((10, 12), np.bool_), 1)
    free[5, 6] = False
    parts = cut_into_parts(free, local_widths(free), 3)
    assert (parts.cells.tolist(), parts.loops) == ([119], 0)
    assert furniture_share(free) == 1 / 120
    free[2:5, 2:8] = False
    assert furniture_share(free) == 0.0  # now one piece of 19 cells


def test_the_width_at_a_cell_is_that_of_the_largest_square_over_it():
    free = np.random.default_rng(3).random((14, 17)) < 0.85
    free[4:10, 3:12] = True
    expected = np.zeros(free.shape, int)
    for side in range(1, 15):
        for row in range(15 - side):
            for col in range(18 - side):
                if free[row : row + side, col : col + side].all():
                    expected[row : row + side, col : col + side] = side
    assert (local_widths(free) == expected).all()
    assert local_widths(free).max() >= 6


def test_walls_are_straight_in_runs():
    assert straight_share(np.pad(np.ones((5, 9), np.bool_), 1)) == 1.0
    assert straight_share(np.pad(np.ones((5, 4), np.bool_), 1)) == 10 / 18
    assert straight_share(np.pad(np.eye(5, dtype=np.bool_), 1)) == 0.0


def test_statistics_do_not_depend_on_the_space_around_nor_on_mirrors():
    free = FloorsMaps(turned=0.0, ragged=0.0).draw(np.random.default_rng(4))
    plain, padded, mirrored = (map_statistics(each) for each in (free, np.pad(free, 7), free.T[::-1]))
    assert list(plain) == [kind.name for kind in STATISTICS]
    for name, values in plain.items():
        assert sorted(values) == pytest.approx(sorted(padded[name]))
        assert sorted(values) == pytest.approx(sorted(mirrored[name]))
    assert plain["floor"].tolist() == [free.sum()]
    assert len(plain["width"]) == free.sum()


def test_a_floor_of_one_cell_has_statistics():
    found = map_statistics(np.pad(np.ones((1, 1), np.bool_), 1))
    assert (found["floor"].tolist(), found["free share"].tolist(), found["loops"].tolist()) == ([1.0], [1.0], [0.0])
    assert found["room"].tolist() == [1.0]
