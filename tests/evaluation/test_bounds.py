"""No team beats the lower bound, not even one that knows the map."""

from collections import deque

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, World
from indoor_explorers.env.lidar import scan
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.bounds import least_steps

MOVES = ((1, 0), (0, -1), (-1, 0), (0, 1))


def fewest_steps(truth, start, reach, share):
    """Search all ways of one UAV breadth-first: the fewest steps to a share of the free cells."""
    needed = int(np.ceil(share * (truth == 1).sum() - 1e-9))

    def seen(cell):
        return frozenset(np.flatnonzero(scan(truth, cell, reach) == 1).tolist())

    first = (start, seen(start))
    queue, known = deque([(first, 0)]), {first}
    while queue:
        (cell, covered), steps = queue.popleft()
        if len(covered) >= needed:
            return steps
        for row, column in MOVES:
            there = (cell[0] + row, cell[1] + column)
            inside = 0 <= there[0] < truth.shape[0] and 0 <= there[1] < truth.shape[1]
            if inside and truth[there] == 1 and (state := (there, covered | seen(there))) not in known:
                known.add(state)
                queue.append((state, steps + 1))
    raise AssertionError("the map is not connected")


@pytest.mark.parametrize("seed", range(6))
def test_the_best_way_there_is_takes_no_less(seed):
    rng = np.random.default_rng(seed)
    truth = np.ones((4, 7), np.uint8)
    truth[1:3, int(rng.integers(1, 6))] = 2
    scenario = PRESETS["thesis-open"].for_evaluation().with_settings({"lidar.range": 1.0})
    world = World(scenario)
    world.begin(0, 0, floorplan=Floorplan(truth, "small"), spawns=[(0, 0)])
    for share in (0.5, 0.9, 1.0):
        bound = least_steps(world, 0, share)
        assert bound <= fewest_steps(truth, (0, 0), 1.0, share)
    assert least_steps(world, 0, 1.0) >= 7


def test_an_open_hall_is_worked_out_by_hand():
    scenario = PRESETS["thesis-open"].for_evaluation()
    world = World(scenario)
    world.begin(0, 0, floorplan=Floorplan(np.ones((16, 16), np.uint8), "hall"), spawns=[(8, 8)])
    assert least_steps(world, 0, 0.9) == -(-(231 - 29) // 7) == 29
    assert least_steps(world, 0, 0.05) == 0
