"""The observation: symmetric, complete, and of nothing but the belief."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.env import FREE, UNKNOWN, World
from indoor_explorers.env.arrays import Belief
from indoor_explorers.env.grid import MOVES, distance_field
from indoor_explorers.env.lidar import view_gain
from indoor_explorers.learners.dddqn.observation import COARSE, FINE, MOVE_FEATURES, SCENE, observe, remember
from indoor_explorers.learners.dddqn.sensor import scratch, sensor
from indoor_explorers.learners.dddqn.symmetry import SYMMETRIES, symmetries, turned
from tests.learners.rooms import random_belief, small_room

Numbers = tuple[NDArray[np.uint8], NDArray[np.float32], int]


def observed(
    belief: Belief, cell: tuple[int, int], visits: NDArray[np.uint8] | None = None, lidar: float = 3.0
) -> Numbers:
    scene, moves = np.zeros(SCENE, np.uint8), np.zeros((4, len(MOVE_FEATURES)), np.float32)
    if visits is None:
        visits = np.zeros(belief.shape, np.uint8)
    belief = np.ascontiguousarray(belief)
    nearest = observe(belief, *cell, visits, sensor(lidar), scratch(belief.shape, sensor(lidar)), scene, moves)
    return scene, moves, nearest


def test_it_has_728_numbers() -> None:
    assert SCENE + 4 * len(MOVE_FEATURES) == 728


@pytest.mark.parametrize("lidar", [1.0, 3.0, 7.0, 12.5])
@pytest.mark.parametrize("symmetry", range(SYMMETRIES))
def test_turning_the_world_permutes_the_numbers(symmetry: int, lidar: float) -> None:
    rng = np.random.default_rng(symmetry)
    tables = symmetries()
    for _ in range(5):
        belief, cell = random_belief(rng)
        visits = rng.integers(0, 6, belief.shape, dtype=np.uint8)
        scene, moves, nearest = observed(belief, cell, visits, lidar)
        marked = np.zeros(belief.shape)
        marked[cell] = 1
        row, col = np.argwhere(turned(marked, symmetry))[0].tolist()
        turned_visits = np.ascontiguousarray(turned(visits, symmetry))
        got = observed(turned(belief, symmetry), (row, col), turned_visits, lidar)
        assert np.array_equal(got[0], scene[tables.scene[symmetry]])
        np.testing.assert_allclose(got[1], moves[tables.moves[symmetry]], atol=1e-6)
        assert got[2] == nearest


def test_moves_turn_with_the_world() -> None:
    for symmetry, row in enumerate(symmetries().action):
        for action in range(4):
            before, after = np.zeros((5, 5)), np.zeros((5, 5))
            before[tuple(2 + MOVES[action])] = 1
            after[tuple(2 + MOVES[row[action]])] = 1
            assert np.array_equal(turned(before, symmetry), after)


def test_it_depends_on_nothing_outside_the_belief() -> None:
    rng = np.random.default_rng(5)
    scenario = small_room()
    world = World(scenario, 2)
    world.reset([1, 1])
    for _ in range(30):
        views = [world.view(b, 0) for b in range(2)]
        world.state.truth[1][views[1].belief == UNKNOWN] = rng.integers(1, 3)
        first, second = (observed(view.belief, view.cell) for view in views)
        assert np.array_equal(views[0].belief, views[1].belief)
        assert np.array_equal(first[0], second[0])
        assert np.array_equal(first[1], second[1])
        world.state.truth[1] = world.state.truth[0]
        action = rng.choice(np.flatnonzero(views[0].legal))
        world.step(np.full((2, 1), action))


def test_the_maps_show_what_is_around() -> None:
    belief, (row, col) = random_belief(np.random.default_rng(8))
    scene, _, _ = observed(belief, (row, col))
    reach = FINE // 2
    padded = np.pad(belief, reach, constant_values=2)[row : row + FINE, col : col + FINE]
    maps = scene[: 2 * FINE * FINE].reshape(2, FINE, FINE)
    assert np.array_equal(maps[0] == 255, padded == UNKNOWN)
    assert np.array_equal(maps[1] == 255, padded == FREE)
    reach = 3 * COARSE // 2
    padded = np.pad(belief, reach, constant_values=2)[row : row + 3 * COARSE, col : col + 3 * COARSE]
    blocks = (padded == UNKNOWN).reshape(COARSE, 3, COARSE, 3).sum(axis=(1, 3))
    coarse = scene[2 * FINE * FINE :][: COARSE * COARSE].reshape(COARSE, COARSE)
    assert np.array_equal(coarse, np.rint(255 * blocks / 9))


def test_the_move_features_are_what_they_say() -> None:
    belief, (row, col) = random_belief(np.random.default_rng(9))
    visits = np.full(belief.shape, 2, np.uint8)
    _, moves, _ = observed(belief, (row, col), visits)
    disc = sensor(3.0).disc
    for k in range(4):
        r, c = (np.array((row, col)) + MOVES[k]).tolist()
        if not (0 <= r < belief.shape[0] and 0 <= c < belief.shape[1] and belief[r, c] == FREE):
            assert moves[k].tolist() == [1, 0, 1, 0, 0, 0, 0, 0]
            continue
        steps = distance_field(belief, (r, c))
        places = [(int(r), int(c)) for r, c in np.argwhere(steps < 1000)]
        gains = {place: view_gain(belief, place, 3.0) / disc for place in places}
        nearest = min(steps[place] for place, gain in gains.items() if gain > 0)
        expected = [0.0, gains[r, c] ** 0.5, nearest / (nearest + 8)]
        expected += [max(gain * k ** steps[at] for at, gain in gains.items()) ** 0.5 for k in (0.7, 0.85, 0.95)]
        expected += [sum(gain * 0.7 ** steps[at] for at, gain in gains.items()) ** 0.5, 0.5]
        np.testing.assert_allclose(moves[k], expected, rtol=1e-5)


def test_nothing_in_reach_is_told_apart() -> None:
    belief = np.full((6, 7), FREE, np.uint8)
    assert observed(belief, (2, 3))[2] == -1
    belief[5, 6] = UNKNOWN
    assert observed(belief, (5, 5))[2] == 0


def test_visits_are_forgotten_after_a_gain_of_its_own() -> None:
    belief, noted, visits = (np.zeros((4, 9), np.uint8) for _ in range(3))
    belief[:2, :3] = FREE
    assert remember(belief, 0, 0, sensor(3.0), noted, visits) == 6
    assert remember(belief, 0, 1, sensor(3.0), noted, visits) == 0
    assert remember(belief, 0, 0, sensor(3.0), noted, visits) == 0
    assert visits[0, :2].tolist() == [2, 1]
    belief[0, 8] = FREE  # out of sight: heard by radio
    assert remember(belief, 0, 1, sensor(3.0), noted, visits) == 0
    assert visits[0, :2].tolist() == [2, 2]
    belief[2, :3] = FREE
    assert remember(belief, 1, 0, sensor(3.0), noted, visits) == 3
    assert visits.sum() == visits[1, 0] == 1
