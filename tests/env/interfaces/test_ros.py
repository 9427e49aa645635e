"""Grids, poses and goals as ROS has them, on messages that are nothing but their fields."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from indoor_explorers.env import FREE, OCCUPIED, UNKNOWN, Action, Briefing, InputError, World, make_policy, scenario
from indoor_explorers.env.interfaces import Goal, GridFrame, Robot

BELIEFS = arrays.arrays(np.uint8, arrays.array_shapes(min_dims=2, max_dims=2, max_side=12), elements=st.integers(0, 2))


def grid_message(data, shape, resolution=1.0, origin=(0.0, 0.0), z=0.0):
    position = SimpleNamespace(x=origin[0], y=origin[1], z=0.0)
    corner = SimpleNamespace(position=position, orientation=SimpleNamespace(x=0.0, y=0.0, z=z, w=1.0))
    info = SimpleNamespace(height=shape[0], width=shape[1], resolution=resolution, origin=corner)
    return SimpleNamespace(info=info, data=data)


def pose_message(x, y):
    return SimpleNamespace(pose=SimpleNamespace(position=SimpleNamespace(x=x, y=y, z=0.4)))


@given(BELIEFS, st.floats(0.05, 3.0), st.tuples(st.floats(-20, 20), st.floats(-20, 20)))
def test_beliefs_and_cells_come_back(belief, resolution, origin):
    frame = GridFrame(shape=belief.shape, resolution=resolution, origin=origin)
    data = frame.occupancy(belief)
    np.testing.assert_array_equal(frame.belief(grid_message(data, belief.shape, resolution, origin)), belief)
    np.testing.assert_array_equal(frame.belief(data.reshape(belief.shape)), belief)
    for cell in np.ndindex(belief.shape):
        assert frame.cell(*frame.point(cell)) == cell


def test_rows_grow_against_y():
    frame = GridFrame(shape=(2, 3), resolution=0.5, origin=(1.0, -1.0))
    belief = np.array([[UNKNOWN, FREE, OCCUPIED], [FREE, FREE, FREE]], np.uint8)
    assert frame.occupancy(belief).tolist() == [0, 0, 0, -1, 0, 100]
    assert frame.point((0, 0)) == (1.25, -0.25)
    assert frame.cell(2.4, -0.9) == (1, 2)


def test_values_between_free_and_occupied_are_unknown():
    frame = GridFrame(shape=(1, 9))
    values = np.array([[-1, 0, 25, 26, 64, 65, 100, 101, -128]], np.int8)
    assert frame.belief(values).tolist() == [[0, 1, 1, 0, 0, 2, 2, 0, 0]]


def test_a_grid_may_be_smaller_than_its_frame_and_grow():
    frame = GridFrame(shape=(4, 5), resolution=0.5)
    belief = frame.belief(grid_message([0, 100], (1, 2), 0.5, (1.0, 0.5)))
    assert np.argwhere(belief).tolist() == [[2, 2], [2, 3]]
    wide = [-1] * 60
    wide[11] = 0
    assert np.argwhere(frame.belief(grid_message(wide, (6, 10), 0.5, (-0.5, -0.5)))).tolist() == [[3, 0]]


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"resolution": 0.05}, "expected a grid of 1 m a cell, got 0.05"),
        ({"z": 0.1}, "not turned"),
        ({"origin": (0.3, 0.0)}, "expected an origin whole cells of 1 m from"),
        ({"origin": (2.0, 0.0)}, "make the frame larger"),
        ({"origin": (0.0, -1.0)}, "make the frame larger"),
    ],
)
def test_grids_that_do_not_fit_are_refused(given, told):
    frame = GridFrame(shape=(2, 3))
    with pytest.raises(InputError, match=told):
        frame.belief(grid_message([0] * 6, (2, 3), **given))


def test_what_is_off_the_map_is_refused():
    frame = GridFrame(shape=(2, 3))
    with pytest.raises(InputError, match="expected a point on the map"):
        frame.cell(3.1, 0.5)
    with pytest.raises(InputError, match="expected an array of shape"):
        frame.belief(np.zeros((3, 2), np.int8))
    with pytest.raises(InputError, match="resolution above 0"):
        GridFrame(shape=(2, 3), resolution=0.0)
    robot = Robot(frame, budget=9)
    with pytest.raises(InputError, match="expected a view before"):
        robot.goal(Action.UP)
    robot.view(np.zeros((2, 3), np.int8), (0.5, 0.5))
    with pytest.raises(InputError, match="expected a point on the map"):
        robot.goal(Action.LEFT)


def test_goals_are_the_centres_of_cells():
    robot = Robot(GridFrame(shape=(3, 3), resolution=2.0, origin=(10.0, 0.0)), budget=9)
    robot.view(np.zeros((3, 3), np.int8), pose_message(13.9, 2.1))
    assert robot.goal(Action.STAY) == Goal(13.0, 3.0, 0.0)
    assert robot.goal(Action.RIGHT) == Goal(15.0, 3.0, 0.0)
    assert robot.goal(Action.LEFT) == Goal(11.0, 3.0, math.pi)
    assert robot.goal(Action.UP) == Goal(13.0, 5.0, math.pi / 2)
    assert robot.goal(Action.DOWN) == Goal(13.0, 1.0, -math.pi / 2)
    assert robot.goal(Action.STAY).yaw == -math.pi / 2
    np.testing.assert_allclose(robot.goal(Action.STAY).quaternion, (0, 0, -math.sqrt(0.5), math.sqrt(0.5)))


def test_teammates_age_from_the_step_they_were_heard():
    robot = Robot(GridFrame(shape=(1, 4)), budget=9)
    grid = np.zeros((1, 4), np.int8)
    robot.hear(2, pose_message(3.5, 0.5), (1.0, 2.0))
    assert robot.view(grid, (0.5, 0.5)).mates == ((2, (0, 3), 0, (1.0, 2.0)),)
    robot.hear(1, (2.5, 0.5))
    view = robot.view(grid, (1.5, 0.5))
    assert view.mates == ((1, (0, 2), 0, None), (2, (0, 3), 1, (1.0, 2.0)))
    assert (view.step, view.budget, view.visited.tolist()) == (1, 9, [[True, True, False, False]])


def test_views_cannot_be_written_to_and_know_their_own_cell():
    robot = Robot(GridFrame(shape=(1, 3)), budget=9)
    view = robot.view(np.full((1, 3), -1, np.int8), (1.5, 0.5))
    assert view.belief.tolist() == [[UNKNOWN, FREE, UNKNOWN]]
    assert view.legal.tolist() == [False, False, False, False, True]
    for array in (view.belief, view.legal, view.visited):
        assert not array.flags.writeable


@pytest.mark.parametrize("policy", ["frontier-nearest", "pso"])
def test_a_planner_flies_the_same_through_grids_and_goals(policy):
    world = World(scenario("thesis-obstacles"))
    world.reset(seeds=[5])
    frame = GridFrame(shape=world.state.truth.shape[1:], resolution=0.4, origin=(-3.0, 2.0))
    robot = Robot(frame, budget=int(world.state.budget[0]))
    pilot, other = (make_policy(policy).pilot(world.briefing(0, 0)) for _ in range(2))
    where = frame.point(world.view(0, 0).cell)
    while world.flying.any():
        view = world.view(0, 0)
        action = pilot.act(view)
        told = robot.view(frame.occupancy(view.belief).reshape(frame.shape), where)
        assert other.act(told) == action
        where = robot.goal(action)[:2]
        world.step(np.array([[action]]))
    assert frame.cell(*where) == world.view(0, 0).cell


def test_a_planner_takes_another_way_where_a_mapper_finds_an_obstacle():
    frame = GridFrame(shape=(5, 12))
    belief = np.full(frame.shape, FREE, np.uint8)
    belief[:, 11] = UNKNOWN
    briefing = Briefing(
        agent=0,
        team=1,
        shape=frame.shape,
        lidar_range=5.0,
        scenario=scenario("thesis-open"),
        rng=np.random.default_rng(0),
    )
    pilot, robot = make_policy("frontier-nearest").pilot(briefing), Robot(frame, budget=99)

    def decided(col):
        view = robot.view(frame.occupancy(belief).reshape(frame.shape), frame.point((2, col)))
        return pilot.act(view), view.log_odds is not None

    assert decided(2) == decided(3) == (Action.RIGHT, False)
    belief[2, 5] = OCCUPIED  # no more cells are known than before
    action, uncertain = decided(4)
    assert action in (Action.UP, Action.DOWN)
    assert uncertain
