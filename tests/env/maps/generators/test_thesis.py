"""The thesis's random rooms, in Python and as compiled code opens episodes in them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env import InputError, Scenario, World
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.generators.thesis import ThesisMaps
from indoor_explorers.env.simulation.spawns import draw_floorplan, draw_spawns


def solid(seed, **options):
    """(H, W) bool: the obstacles of a seed's room."""
    return ThesisMaps(**options).floorplan(0, seed).truth == OCCUPIED


def test_rooms_follow_their_settings():
    assert (solid(7) == solid(7)).all()
    assert (solid(7) != solid(8)).any()
    assert not solid(1, obstacles=0).any()
    for seed in range(200):
        assert 9 <= solid(seed).sum() <= 45
        assert not solid(seed)[0].any()
        assert not solid(seed)[:, 0].any()


def test_a_rectangle_lies_anywhere_that_the_ancestor_puts_it():
    rooms = [solid(seed, obstacles=1) for seed in range(500)]
    assert {int(room.sum()) for room in rooms} <= {9, 6, 4}  # cut off at the lower or right border
    corners = np.array([np.argwhere(room)[0] for room in rooms])
    assert corners.min(axis=0).tolist() == [1, 1]
    assert corners.max(axis=0).tolist() == [13, 13]
    counts = np.bincount(corners[:, 0], minlength=14)[1:]
    assert counts.min() > 0.5 * counts.mean()


def test_rooms_may_have_any_shape_and_obstacle_size():
    room = solid(3, height=9, width=21, obstacles=4, obstacle_size=(1, 6), margin=2)
    assert room.shape == (9, 21)
    assert not room[:2].any()
    assert solid(0, height=2, width=50, obstacles=3, margin=5).shape == (2, 50)


def test_a_lattice_stands_on_its_rows_and_columns():
    room = solid(0, height=20, width=31, rows=3, columns=4, obstacle_size=(1, 1), margin=2)
    assert np.argwhere(room).tolist() == [[row, col] for row in (2, 9, 17) for col in (2, 10, 19, 28)]


def test_noise_moves_the_rectangles_of_a_lattice_up_to_so_many_cells():
    lattice = {"height": 30, "width": 30, "rows": 2, "columns": 2, "obstacle_size": (1, 1), "margin": 6, "noise": 3}
    found = [sorted(np.argwhere(solid(seed, **lattice)), key=lambda cell: tuple(cell > 14)) for seed in range(60)]
    moved = np.array(found) - [[6, 6], [6, 23], [23, 6], [23, 23]]
    assert moved.min() == -3
    assert moved.max() == 3
    assert len({tuple(cells.ravel()) for cells in moved}) == 60


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**63 - 1), st.sampled_from(["random", "clustered"]), st.sampled_from(["map", "reachable"]))
def test_compiled_openings_equal_those_in_python(seed, spawn, denominator):
    """Restarting many episodes in compiled code and beginning each from a floor plan is the same."""
    scenario = Scenario(
        map={"source": "thesis", "height": 9, "width": 12, "obstacles": 14, "obstacle_size": [1, 4]},
        team=3,
        spawn=spawn,
        denominator=denominator,
        goal=0.6,
        radio={"model": "disc", "range": 4.0},
    )
    worlds = World(scenario, 2), World(scenario, 2)
    worlds[0].reset([seed, seed ^ 1])
    for b in range(2):
        worlds[1].begin(b, 5, floorplan=scenario.map.floorplan(0, 1))  # leaves nothing behind
        plan = draw_floorplan(scenario, seed ^ b)
        worlds[1].begin(b, seed ^ b, floorplan=plan, spawns=draw_spawns(scenario, plan, seed ^ b))
    for name, array in worlds[0].state._asdict().items():
        np.testing.assert_array_equal(array, getattr(worlds[1].state, name), err_msg=name)
    assert (worlds[0].state.truth[0] == worlds[0].floorplan(0).truth).all()
    assert worlds[0].floorplan(0).digest == worlds[1].floorplan(0).digest


def test_a_room_that_will_not_do_is_drawn_again_and_at_last_refused():
    crowded = Scenario(map={"source": "thesis", "height": 6, "width": 6, "obstacles": 6}, team=14)
    world = World(crowded, 30)
    world.reset(range(30))
    assert ((world.state.truth == FREE).sum(axis=(1, 2)) >= 14).all()
    with pytest.raises(InputError, match="expected room for 40 UAVs"):
        World(crowded.with_settings({"team": 40})).reset([0])
