"""Doorways, straight walls and free-standing obstacles, in maps drawn by hand and in generated ones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from indoor_explorers.env import scenario
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.walls import (
    LARGEST,
    SHORTEST,
    THICKEST,
    WIDEST,
    doorways,
    standing_obstacles,
    straight_walls,
)
from indoor_explorers.env.simulation.spawns import draw_floorplan

MAPS = st.builds(
    lambda solid: np.where(solid, OCCUPIED, FREE).astype(np.uint8),
    arrays(np.bool_, st.tuples(st.integers(1, 14), st.integers(1, 14))),
)
ROOMS = """
###########
#....#....#
#.........#
#....#....#
#....#..#.#
##.###....#
#....#....#
#....######
#.........#
###########
"""


def drawn(picture):
    rows = picture.split()
    return np.array([[OCCUPIED if cell == "#" else FREE for cell in row] for row in rows], np.uint8)


def places(blocks):
    return sorted(block[:4] for block in blocks)


def test_doorways_walls_and_obstacles_of_two_rooms():
    truth = drawn(ROOMS)
    assert places(doorways(truth)) == [(2, 5, 1, 1), (5, 2, 1, 1)]
    assert places(straight_walls(truth)) == [(7, 6, 1, 4)]
    assert [(box[0].start, box[1].start, int(mask.sum())) for mask, box in standing_obstacles(truth)] == [(4, 8, 1)]


def test_a_corridor_is_no_doorway_and_neither_is_a_gap_between_obstacles():
    corridor = drawn("########### #....#....# #....#....# #.........# #....#....# #....#....# ###########")
    assert places(doorways(corridor)) == [(3, 5, 1, 1)]
    side_doors = drawn("######### #...#...# ##.###.## #.......# ##.###.## #...#...# #########")
    assert places(doorways(side_doors)) == [(2, 2, 1, 1), (2, 6, 1, 1), (4, 2, 1, 1), (4, 6, 1, 1)]
    pillars = drawn("......... ..#.#.... ......... .........")
    assert not doorways(pillars)
    assert len(standing_obstacles(pillars)) == 2


@given(MAPS)
@settings(max_examples=150, deadline=None)
def test_what_each_kind_is_made_of(truth):
    for door in doorways(truth):
        across, through = (door.height, door.width) if door.upright else (door.width, door.height)
        assert across <= WIDEST
        assert through <= THICKEST
        assert (truth[door.cells] == FREE).all()
    for wall in straight_walls(truth):
        cells = truth.T[wall.turned.cells] if wall.upright else truth[wall.cells]
        whole, block = (truth.T, wall.turned) if wall.upright else (truth, wall)
        assert (cells == OCCUPIED).all()
        assert block.width >= SHORTEST
        assert block.height <= THICKEST
        for row in (block.top - 1, block.top + block.height):
            assert (whole[row, block.left : block.left + block.width] == FREE).all()
    for mask, box in standing_obstacles(truth):
        assert max(mask.shape) <= LARGEST
        assert (truth[box][mask] == OCCUPIED).all()
        around = tuple(slice(part.start - 1, part.stop + 1) for part in box)
        assert (truth[around][~np.pad(mask, 1)] == FREE).sum() >= 4


@given(MAPS)
@settings(max_examples=100, deadline=None)
def test_a_turned_map_has_the_same_parts_turned(truth):
    for find in (doorways, straight_walls):
        assert places(block.turned for block in find(truth)) == places(find(np.ascontiguousarray(truth.T)))


@pytest.mark.parametrize("name", ["small-floors", "small-offices"])
def test_generated_buildings_have_some_of_each(name):
    truth = draw_floorplan(scenario(name), 9_000_000, 0).truth
    assert len(doorways(truth)) >= 20
    assert len(straight_walls(truth)) >= 10
