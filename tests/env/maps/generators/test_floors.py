"""Floor plans: connected for every legal setting, of the area asked for, and built as buildings are."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.generators.floors.doors import Door, doors, open_doors, walls_between
from indoor_explorers.env.maps.generators.floors.finish import mirrored, ragged, set_fire_doors, set_niches, turned
from indoor_explorers.env.maps.generators.floors.site import OPEN, Site, depth_free
from indoor_explorers.env.maps.generators.floors.skeletons import Corridor
from indoor_explorers.env.maps.generators.floors.style import draw_style
from indoor_explorers.env.maps.sources import FloorsMaps
from indoor_explorers.env.search.connected_parts import connected_parts
from tests.env.maps.generators.test_generators import one_connected_floor

shares = st.floats(0.0, 1.0)
plans = st.builds(
    FloorsMaps,
    height=st.integers(32, 150),
    width=st.integers(32, 150),
    resolution=st.floats(0.25, 2.0),
    area=st.tuples(st.floats(1.0, 3000.0), st.floats(1.0, 3000.0)).map(sorted).map(tuple),
    loops=shares,
    furniture=st.floats(0.0, 0.3),
    turned=shares,
    ragged=shares,
)


@settings(max_examples=8, deadline=None)
@given(plans, st.integers(0, 2**32))
def test_any_legal_setting_gives_one_connected_floor_inside_walls(maps, seed):
    assert one_connected_floor(maps, seed).resolution == maps.resolution


def test_floors_have_about_the_area_asked_for():
    sizes = np.array([FloorsMaps().draw(np.random.default_rng(seed)).sum() / 4.0 for seed in range(25)])
    assert 250.0 < sizes.min() < 1200.0
    assert 2200.0 < sizes.max() < 4700.0
    assert 1000.0 < np.median(sizes) < 2500.0
    for resolution in (0.5, 1.0):
        small = FloorsMaps(height=100, width=120, area=(500.0, 500.0), resolution=resolution)
        sizes = np.array([small.draw(np.random.default_rng(seed)).sum() * resolution**2 for seed in range(10)])
        assert 300.0 < sizes.min() <= sizes.max() < 800.0


def test_shares_of_plans_decide_what_is_turned_furnished_and_ragged():
    plain = FloorsMaps(turned=0.0, ragged=0.0, furniture=0.0)
    straight = _straight(plain)
    for change in ({"turned": 1.0}, {"ragged": 1.0}, {"furniture": 0.3}):
        assert _straight(plain.model_copy(update=change)) < straight - 0.04


def _straight(maps):
    """Return the share of cells beside a wall whose neighbours along it are beside it too."""
    kept = total = 0
    for seed in range(6):
        free = maps.floorplan(0, seed).truth == FREE
        below = free[:-1] & ~free[1:]
        kept += (below[:, 1:] & below[:, :-1]).sum()
        total += below.sum()
    return kept / total


def test_more_loops_part_the_walls():
    """Walls of a tree of rooms hang together; every loop cuts off a piece of them."""
    plain = FloorsMaps(turned=0.0, ragged=0.0, furniture=0.0)
    few, many = (
        sum(_pieces_of_wall(plain.model_copy(update={"loops": loops}).floorplan(0, seed)) for seed in range(6))
        for loops in (0.0, 0.5)
    )
    assert many > 3 * few


def _pieces_of_wall(plan):
    from scipy import ndimage

    return ndimage.label(plan.truth == OCCUPIED, np.ones((3, 3)))[1]


TWO_ROOMS = np.array(
    [
        [-1, -1, -1, -1, -1, -1, -1, -1],
        [-1, 2, 2, 0, 3, 3, 3, -1],
        [-1, 2, 2, 0, 3, 3, 3, -1],
        [-1, 0, 0, 0, 0, 0, 0, -1],
        [-1, 1, 1, 1, 1, 1, 1, -1],
        [-1, -1, -1, -1, -1, -1, -1, -1],
    ],
    np.int32,
)


def test_walls_lie_between_spaces():
    walls = walls_between(TWO_ROOMS)
    found = sorted(zip(*(column.tolist() for column in walls), strict=True))
    assert found == [(OPEN, 2, 0, 1, 3, 1, 2), (OPEN, 3, 0, 1, 3, 4, 3), (2, 3, 1, 1, 1, 3, 2)]
    thick = np.insert(TWO_ROOMS, 3, 0, axis=0)
    assert (walls_between(thick).thick == [2, 2, 1]).all()


def test_doors_join_all_spaces_and_every_wall_has_one_with_all_loops():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        few, every = (draw_style(rng, 0.5, 0.0, 0.0)._replace(loops=loops) for loops in (0.0, 1.0))
        free = TWO_ROOMS > 0
        made = doors(rng, TWO_ROOMS, few)
        assert len(made) == 2
        open_doors(free, made)
        assert len(connected_parts(free)[1]) == 2
        assert len(doors(rng, TWO_ROOMS.repeat(2, axis=0).repeat(2, axis=1), every)) >= 3


def test_rooms_keep_a_wall_to_what_is_there():
    assert depth_free(TWO_ROOMS[4:], 2, 4, 0, 5) == -1
    assert depth_free(np.zeros((9, 9), np.int32), 2, 5, 1, 5) == 5
    blocked = np.zeros((9, 9), np.int32)
    blocked[6, 5] = 7
    assert depth_free(blocked, 2, 5, 1, 8) == 4
    assert depth_free(blocked, 1, 4, 1, 8) == 8 - 1


@pytest.mark.parametrize("degrees", range(0, 91, 9))
def test_a_turned_plan_keeps_its_doors_open(degrees):
    free = np.zeros((40, 40), np.bool_)
    free[5:35, 5:20] = free[5:35, 21:35] = True
    door = Door(18, 20, 1, 1, 1)
    free[18, 20] = True
    out = turned(free, [door], np.radians(degrees))
    assert len(connected_parts(out)[1]) == 2
    assert abs(out.sum() - free.sum()) < 0.05 * free.sum()


def test_ragged_walls_close_cells_beside_walls_alone():
    free = np.zeros((60, 60), np.bool_)
    free[1:-1, 1:-1] = True
    out = ragged(np.random.default_rng(0), free, 0.15)
    assert out[2:-2, 2:-2].all()
    assert 0.05 < (free & ~out).sum() / (4 * 57) < 0.3


def test_a_plan_with_an_axis_of_symmetry_is_mirrored_with_its_doors():
    rng = np.random.default_rng(0)
    spaces = np.zeros((9, 20), np.int32)
    spaces[1:4, 1:5], spaces[1:4, 6:15], spaces[5:8, 1:15] = 2, 3, OPEN
    free = spaces > 0
    made = [Door(4, 2, 1, 1, 0), Door(4, 8, 1, 2, 0)]
    open_doors(free, made)
    out, rooms, both = mirrored(rng, free, spaces, made, 40)
    assert (out == out[:, ::-1]).all()
    assert out.shape == rooms.shape
    assert len(both) == 4
    assert all(out[door.row, door.col : door.col + door.wide].all() for door in both)
    assert len(connected_parts(out)[1]) == 2
    assert set(np.unique(rooms)) == {0, OPEN, 2, 3, 5, 6}
    assert mirrored(rng, free, spaces * (spaces > OPEN), made, 40)[0] is free  # no corridor to lay it through


def test_fire_doors_leave_a_way_through_and_niches_part_nothing():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        style = draw_style(rng, 0.5, 0.1, 0.0)._replace(fire_doors=3.0, niches=1.0)
        site = Site(20, 120)
        site.spaces[5:9, 2:118] = OPEN
        set_fire_doors(rng, site, [Corridor(5, 2, 4, 116)], style)
        free = site.spaces == OPEN
        assert free.sum() < 4 * 116
        assert len(connected_parts(free)[1]) == 2
        room = np.zeros((30, 30), np.bool_)
        room[1:-1, 1:-1] = True
        set_niches(rng, room, np.array([[1, 1, 28, 28]]), style)
        assert room.sum() < 28 * 28
        assert len(connected_parts(room)[1]) == 2
