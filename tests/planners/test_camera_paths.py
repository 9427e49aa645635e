"""Paths for a narrow view: as short as others, and those on which the sensor sees most."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import InputError, World, make_policy, scenario
from indoor_explorers.env.grid.cells import FREE, MOVES, UNKNOWN
from indoor_explorers.env.sensing.lidar import lidar_model
from indoor_explorers.planners.camera_paths import CameraPaths
from indoor_explorers.planners.toolbox.navigation.camera_moves import CameraMoves, move_gains
from indoor_explorers.planners.toolbox.navigation.navigator import Navigator
from indoor_explorers.planners.toolbox.navigation.paths import Paths, map_stamp
from tests.planners.flights import fly_preset

NARROW = {"lidar.field_of_view": 90}


def narrow_world(seed: int = 0) -> World:
    """A room without obstacles, one UAV whose sensor sees 90 degrees."""
    world = World(scenario("thesis-open").with_settings({**NARROW, "lidar.range": 4.0}))
    world.reset(seeds=[seed])
    return world


@pytest.mark.parametrize("seed", range(12))
def test_a_gain_is_what_the_scan_after_the_move_reveals_where_nothing_is_in_the_way(seed):
    world = narrow_world(seed)
    view = world.view(0, 0)
    moves = np.flatnonzero(view.legal[:4])
    briefing = world.briefing(0, 0)
    cosine = np.cos(np.pi / 4) - 1e-9
    gains = move_gains(view.belief, *view.cell, moves, lidar_model(float(briefing.lidar_range)), cosine)
    for move, gain in zip(moves, gains, strict=True):
        world = narrow_world(seed)
        before = np.count_nonzero(world.view(0, 0).belief != UNKNOWN)
        world.step(np.array([[move]]))
        assert np.count_nonzero(world.view(0, 0).belief != UNKNOWN) - before == gain


def paths_to(goal, cell, belief, view, briefing):
    """The cells flown to a goal on a belief that does not change."""
    moves, paths, flown = CameraMoves(briefing), Paths(belief.shape), [cell]
    while flown[-1] != goal:
        now = view._replace(cell=flown[-1], belief=belief, legal=legal_on(belief, flown[-1]))
        flown.append(moves.next_cell(now, paths.to(belief, flown[-1], goal), map_stamp(now)))
    return flown


def legal_on(belief, cell):
    """The moves from a cell into free cells, (5,) bool."""
    inside = np.pad(belief, 1)
    return np.array([inside[cell[0] + 1 + down, cell[1] + 1 + right] == FREE for down, right in MOVES])


@pytest.mark.parametrize("seed", range(5))
def test_flights_to_a_goal_are_as_short_as_the_shortest_path(seed):
    rng = np.random.default_rng(seed)
    belief = np.where(rng.random((16, 16)) < 0.25, UNKNOWN, FREE).astype(np.uint8)
    world = narrow_world()
    view, briefing, paths = world.view(0, 0), world.briefing(0, 0), Paths(belief.shape)
    cells = [divmod(int(cell), 16) for cell in rng.choice(np.flatnonzero(belief == FREE), 8, replace=False)]
    reached = [(cells[0], goal) for goal in cells[1:] if paths.to(belief, cells[0], goal)]
    assert reached
    for cell, goal in reached:
        assert len(paths_to(goal, cell, belief, view, briefing)) == len(paths.to(belief, cell, goal))


def test_it_faces_the_unknown_on_the_way():
    """Two shortest paths around a corner: the one along the unknown side is flown, wherever the other begins."""
    belief = np.full((16, 16), FREE, np.uint8)
    belief[:, 12:] = UNKNOWN
    world = narrow_world()
    view = world.view(0, 0)._replace(cell=(8, 8), belief=belief, legal=legal_on(belief, (8, 8)))
    moves = CameraMoves(world.briefing(0, 0))
    down_first = [(8, 8), (9, 8), (9, 9)]
    assert moves.next_cell(view, down_first, map_stamp(view)) == (8, 9)
    known = view._replace(belief=np.full_like(belief, FREE))
    assert moves.next_cell(known, down_first, map_stamp(known)) == (9, 8)
    detour = [(8, 8), (7, 8), (7, 9), (8, 9), (9, 9)]
    assert moves.next_cell(view, detour, map_stamp(view)) == (7, 8)


def test_a_teammate_is_not_flown_into():
    belief = np.full((16, 16), FREE, np.uint8)
    belief[:, 12:] = UNKNOWN
    world = World(scenario("thesis-team-2-radio-unlimited").with_settings(NARROW))
    world.reset(seeds=[0])
    view = world.view(0, 0)._replace(cell=(8, 8), belief=belief, legal=legal_on(belief, (8, 8)))
    mate = view.mates[0]._replace(cell=(8, 9), age=0)
    moves = CameraMoves(world.briefing(0, 0))
    path = [(8, 8), (9, 8), (9, 9)]
    assert moves.next_cell(view._replace(mates=(mate,)), path, map_stamp(view)) == (9, 8)


@pytest.mark.parametrize("explorer", ["frontier", "rrt", "dddqn-places"])
def test_with_a_view_all_around_it_is_the_explorer(explorer):
    alone = fly_preset(make_policy(explorer), "small-floors", 3, budget=60)[2]
    assert np.array_equal(fly_preset(CameraPaths(explorer=explorer), "small-floors", 3, budget=60)[2], alone)


@pytest.mark.parametrize("explorer", ["frontier-nearest", "rrt", "pso", "dddqn-places"])
def test_with_a_narrow_view_it_flies_by_the_camera(explorer):
    pilots = fly_preset(CameraPaths(explorer=explorer), "small-floors", 3, budget=30, **NARROW)[1]
    assert isinstance(pilots[0, 0].navigator, Navigator)
    assert pilots[0, 0].navigator.camera is not None


def test_it_reaches_90_percent_sooner_than_its_explorer():
    """The sum over eight floors; each floor by itself may go either way."""
    steps = {}
    for policy in (make_policy("frontier-nearest"), CameraPaths(explorer="frontier-nearest")):
        steps[policy.__class__] = sum(
            len(fly_preset(policy, "small-rooms", seed, goal=0.9, team=1, **NARROW)[2]) for seed in range(8)
        )
    alone, with_camera = steps.values()
    assert with_camera < alone


@pytest.mark.parametrize("explorer", ["random", "dddqn", "return-to-base"])
def test_explorers_that_fly_to_no_goals_are_refused(explorer):
    world = narrow_world()
    with pytest.raises(InputError, match="expected an explorer that flies to goals, such as frontier, rrt or"):
        CameraPaths(explorer=explorer).pilot(world.briefing(0, 0))


def test_explorers_have_parameters():
    assert CameraPaths(explorer="frontier-latency(switch_cost=0.7)").make_explorer().switch_cost == 0.7
    with pytest.raises(InputError, match="expected parameters as in pso"):
        CameraPaths(explorer="frontier-latency(0.7)")
