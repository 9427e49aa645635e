"""Scans with errors: the field of view, headings, bumps, and how often the lidar errs."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env import World
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, TURN, Action
from indoor_explorers.env.maps.floorplan import Floorplan
from tests.env.simulation.slam.flights import SWITCHES, begun, disc, random_actions, random_plan, task

seeds = st.integers(0, 2**32)
examples = settings(max_examples=12, deadline=None)
HALL = Floorplan(np.full((21, 21), FREE, np.uint8), "hall")
#: With cells out of sight, all of which would have to be known.
ENDLESS = {"denominator": "map", "budget": 5000}
CORRIDOR = Floorplan(np.full((1, 12), FREE, np.uint8), "corridor")


def placed(scenario, plan, *cells, seed=0):
    world = World(scenario)
    world.begin(0, seed, floorplan=plan, spawns=cells)
    return world


@pytest.mark.parametrize("action", [Action.DOWN, Action.LEFT, Action.UP, Action.RIGHT])
def test_a_field_of_view_of_90_degrees_is_a_quarter_and_the_neighbours(action):
    world = placed(task(1, SWITCHES["field of view"], {"lidar.range": 5.0}), HALL, (10, 10))
    world.step(np.array([[action]]))
    here = world.state.cell[0, 0]
    before = world.slam.log_odds[0, 0].copy()
    world.step(np.array([[Action.STAY]]))
    seen = {tuple(cell) for cell in (np.argwhere(world.slam.log_odds[0, 0] != before) - here).tolist()}
    ahead = {Action.DOWN: (1, 0), Action.LEFT: (0, -1), Action.UP: (-1, 0), Action.RIGHT: (0, 1)}[action]
    expected = set()
    for row, col in np.ndindex(21, 21):
        r, c = row - here[0], col - here[1]
        along, aside = r * ahead[0] + c * ahead[1], abs(r * ahead[1]) + abs(c * ahead[0])
        if max(abs(r), abs(c)) <= 1 or (r * r + c * c <= 25 and along >= aside):
            expected.add((int(r), int(c)))
    assert seen == expected


def test_the_heading_is_the_last_move_and_four_turns_are_none():
    world = placed(task(1, SWITCHES["field of view"]), CORRIDOR, (0, 5))
    first, place = world.view(0, 0).heading, world.view(0, 0).cell
    headings = []
    for _ in range(4):
        world.step(np.array([[TURN]]))
        headings.append(world.view(0, 0).heading)
        assert world.view(0, 0).cell == place
    assert headings == [(first + k) % 4 for k in (1, 2, 3, 4)]
    for action in (Action.RIGHT, Action.UP, Action.STAY, Action.LEFT):  # up is a collision: it looks there all the same
        world.step(np.array([[action]]))
        headings.append(world.view(0, 0).heading)
    assert headings[4:] == [Action.RIGHT, Action.UP, Action.UP, Action.LEFT]
    assert world.state.path_length[0, 0] == 2


def test_turning_is_clockwise():
    """From up to right to down to left, seen with the first row on top."""
    world = placed(task(1, SWITCHES["field of view"]), HALL, (10, 10))
    world.step(np.array([[Action.UP]]))
    for heading in (Action.RIGHT, Action.DOWN, Action.LEFT, Action.UP):
        world.step(np.array([[TURN]]))
        assert world.view(0, 0).heading == heading


@examples
@given(seeds, st.sampled_from([{}, {"noise.misses": 0.1, "noise.false_returns": 0.05}]))
def test_a_smaller_field_of_view_never_knows_more(seed, noise):
    plan = random_plan(seed)
    views = [begun(task(2, disc(4.0), noise, {"lidar.field_of_view": d}), seed, plan) for d in (40.0, 150.0, 359.9)]
    rng = np.random.default_rng(seed)
    for _ in range(15):
        actions = random_actions(rng, views[0])[None]
        for world in views:
            world.step(actions)
            np.testing.assert_array_equal(world.slam.heading, views[0].slam.heading)
        known = [world.state.sensed[0] for world in views]
        for less, more in pairwise(known):
            assert (more | ~less).all()


@examples
@given(seeds)
def test_a_field_of_view_of_360_degrees_is_none(seed):
    noise = {"noise.misses": 0.1, "drift.rate": 0.2}
    one, other = (begun(task(2, disc(4.0), noise, fov), seed) for fov in ({}, {"lidar.field_of_view": 360.0}))
    assert one.scenario.fingerprint == other.scenario.fingerprint
    rng = np.random.default_rng(seed)
    for _ in range(10):
        actions = random_actions(rng, one)[None]
        for world in (one, other):
            world.step(actions)
        np.testing.assert_array_equal(one.slam.log_odds, other.slam.log_odds)


def test_a_bump_is_certain():
    """A UAV that misses an obstacle at each look knows of it once it has flown into it, for long."""
    truth = CORRIDOR.truth.copy()
    truth[0, 6] = OCCUPIED
    world = placed(task(1, {"noise.misses": 0.49}), Floorplan(truth, "blocked"), (0, 5), seed=4)
    world.step(np.array([[Action.RIGHT]]))
    assert world.state.collisions[0, 0] == 1
    assert world.slam.log_odds[0, 0, 0, 6] > 10.0
    for _ in range(20):
        world.step(np.array([[Action.STAY]]))
        assert world.view(0, 0).belief[0, 6] == OCCUPIED


def readings_of(world, steps):
    """(steps, H, W) log-odds that each scan of a UAV that stays where it is adds."""
    sums = [world.slam.log_odds[0, 0].copy()]
    for _ in range(steps):
        world.step(np.full((1, 1), Action.STAY))
        sums.append(world.slam.log_odds[0, 0].copy())
    return np.diff(sums, axis=0)


def test_misses_and_false_returns_are_as_frequent_as_set():
    truth = np.full((3, 3), OCCUPIED, np.uint8)
    truth[1, 1], truth[1, 2] = FREE, FREE
    noise = {"noise.misses": 0.3, "noise.false_returns": 0.1}
    read = readings_of(placed(task(1, noise, ENDLESS, {"lidar.range": 1.0}), Floorplan(truth, "nook"), (1, 1)), 3000)
    assert (read[:, 0, 1] < 0).mean() == pytest.approx(0.3, abs=0.03)
    assert (read[:, 1, 2] > 0).mean() == pytest.approx(0.1, abs=0.02)
    assert set(np.unique(read[:, 0, 1])) == {np.float32(0.875), np.float32(-0.40625)}
    assert set(np.unique(read[:, 1, 1])) == {np.float32(-0.40625 * 16)}


def test_range_errors_are_normal_and_their_number_is_that_of_obstacles():
    truth = np.full((1, 30), FREE, np.uint8)
    truth[0, 15] = OCCUPIED
    noise = {"noise.range_std": 1.5}
    read = readings_of(
        placed(task(1, noise, ENDLESS, {"lidar.range": 20.0}), Floorplan(truth, "corridor"), (0, 3)), 3000
    )
    hits = read[:, 0] > 0
    assert (hits.sum(axis=1) == 1).all()
    errors = hits.argmax(axis=1) - 15
    assert errors.mean() == pytest.approx(0.0, abs=0.1)
    assert errors.std() == pytest.approx((1.5**2 + 1 / 12) ** 0.5, abs=0.1)
    farther = errors > 0
    assert (read[farther, 0, 15] < 0).all(), "the beam went through where the obstacle is"
