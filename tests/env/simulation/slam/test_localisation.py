"""Poses that drift, and what corrects them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env import World
from indoor_explorers.env.grid.cells import FREE, Action
from indoor_explorers.env.maps.floorplan import Floorplan
from tests.env.simulation.slam.flights import disc, task

DOWN, LEFT, UP, RIGHT, STAY = (int(action) for action in Action)
HALL = Floorplan(np.full((30, 30), FREE, np.uint8), "hall")
ALONE = {"drift.closures": 0.0, "drift.mates": False}
seeds = st.integers(0, 2**32)
examples = settings(max_examples=12, deadline=None)


def in_hall(team, *changes, seed=0, spawns=((15, 15),)):
    world = World(task(team, *changes))
    world.begin(0, seed, floorplan=HALL, spawns=spawns)
    return world


def fly(world, *actions):
    for action in actions:
        world.step(np.atleast_2d(action))


def fly_to(world, row, col):
    """Steer one UAV by its true cell, whatever it believes; each step is a move."""
    while True:
        down, right = row - world.state.cell[0, 0, 0], col - world.state.cell[0, 0, 1]
        if abs(down) >= abs(right) > 0 or right == 0:
            fly(world, DOWN if down > 0 else UP)
        else:
            fly(world, RIGHT if right > 0 else LEFT)
        if tuple(world.state.cell[0, 0].tolist()) == (row, col):
            return


def pose_error(world, n=0):
    return float(np.linalg.norm(world.state.believed_cell[0, n] - world.state.cell[0, n]))


def test_a_uav_slips_as_often_as_set_in_any_direction_and_only_when_it_flies():
    world, batch = World(task(1, ALONE, {"drift.rate": 0.2, "lidar.range": 1.0}), 200), range(200)
    for episode in batch:
        world.begin(episode, episode, floorplan=HALL, spawns=[(15, 15)])
    slips = []
    for step in range(20):
        action = (RIGHT, STAY, LEFT, STAY)[step % 4]
        before = world.state.believed_cell - world.state.cell
        world.step(np.full((200, 1), action))
        slips.append((world.state.believed_cell - world.state.cell - before)[:, 0])
        assert action != STAY or not slips[-1].any()
    slips = np.concatenate(slips[::2])
    slipped = slips[slips.any(axis=1)]
    assert len(slipped) / len(slips) == pytest.approx(0.2, abs=0.03)
    directions, counts = np.unique(slipped, axis=0, return_counts=True)
    assert sorted(map(tuple, directions.tolist())) == [(-1, 0), (0, -1), (0, 1), (1, 0)]
    assert counts / len(slipped) == pytest.approx(0.25, abs=0.06)


def test_the_variance_is_that_of_a_random_walk_until_a_loop_is_closed():
    world = in_hall(1, {"drift.rate": 0.25, "drift.closure_gap": 5})
    for flown, action in enumerate((RIGHT, RIGHT, STAY, DOWN, LEFT), start=1):
        fly(world, action)
        moves = flown - (flown >= 3)
        assert world.view(0, 0).pose_std == pytest.approx((0.25 * moves) ** 0.5)
    fly(world, LEFT, UP)  # where it began, seven steps ago
    assert world.view(0, 0).pose_std == 0.0


def test_pose_std_is_the_error_that_poses_have():
    """Over many flights without corrections, the mean squared error is the variance."""
    world = World(task(1, ALONE, {"drift.rate": 0.3, "lidar.range": 1.0}), 500)
    for episode in range(500):
        world.begin(episode, episode, floorplan=HALL, spawns=[(15, 10)])
    for _ in range(10):
        world.step(np.full((500, 1), RIGHT))
    squared = ((world.state.believed_cell - world.state.cell) ** 2).sum(axis=2)
    assert squared.mean() == pytest.approx(world.view(0, 0).pose_std ** 2, rel=0.15)


@examples
@given(seeds)
def test_the_first_cell_is_recognised_and_the_pose_is_right_there(seed):
    world = in_hall(1, {"drift.rate": 0.5, "drift.closure_gap": 3}, seed=seed)
    fly(world, RIGHT, RIGHT, RIGHT, DOWN)
    fly_to(world, 15, 15)
    assert pose_error(world) == 0.0
    assert world.view(0, 0).pose_std == 0.0
    count = world.view(0, 0).step
    truth, drawn = world.slam.true_cell[0, 0], world.slam.drawn_at[0, 0, 0]
    assert truth[0] == drawn[0] == truth[count] == drawn[count]
    bridge = 0.5 * count / 4 + 1e-6
    assert world.slam.variance[0, 0, : count + 1].max() <= bridge, "that of a Brownian bridge of so many cells"
    assert (world.slam.way[0, 0, : count + 1] == np.arange(count + 1)).all()


@pytest.mark.parametrize(
    ("changes", "recognised"),
    [({}, True), ({"drift.closure_gap": 1000}, False), ({"drift.closures": 0.0}, False)],
)
def test_a_loop_is_closed_after_the_gap_and_with_the_chance_that_is_set(changes, recognised):
    errors = []
    for seed in range(12):
        world = in_hall(1, {"drift.rate": 0.5, "drift.closure_gap": 4} | changes, seed=seed)
        fly(world, RIGHT, RIGHT, DOWN, DOWN)
        fly_to(world, 15, 15)
        errors.append(pose_error(world))
    assert (max(errors) == 0.0) is recognised


def test_closures_are_as_frequent_as_set():
    world = World(task(1, {"drift.rate": 0.001, "drift.closure_gap": 4, "drift.closures": 0.3}), 400)
    for episode in range(400):
        world.begin(episode, episode, floorplan=HALL, spawns=[(15, 15)])
    for action in (RIGHT, DOWN, LEFT, UP):
        world.step(np.full((400, 1), action))
    certain = [world.view(episode, 0).pose_std == 0.0 for episode in range(400)]
    assert np.mean(certain) == pytest.approx(0.3, abs=0.07)


@examples
@given(seeds)
def test_a_teammate_in_sight_that_never_moved_makes_the_pose_right(seed):
    far = disc(20.0), {"lidar.range": 20.0}
    world = in_hall(2, {"drift.rate": 0.5}, *far, seed=seed, spawns=((15, 15), (15, 17)))
    for action in (RIGHT, UP, UP, LEFT, LEFT, DOWN):
        fly(world, [STAY, action])
        assert world.state.linked[0, 0, 1]
        assert pose_error(world, 1) == 0.0
        assert world.view(0, 1).pose_std == 0.0
