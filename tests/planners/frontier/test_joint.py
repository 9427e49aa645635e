from __future__ import annotations

import numpy as np

from indoor_explorers.env import make_policy
from indoor_explorers.planners.toolbox.navigation.teammates import message_of
from tests.planners.flights import fly, rooms


def test_it_needs_fewer_steps_than_the_nearest_frontier() -> None:
    halls = [rooms(3, 9, seed) for seed in range(4)]
    maps = [*halls, *(np.ones((16, 16), np.bool_),) * 4]
    steps = {
        name: [fly(make_policy(name), free, seed=seed).steps for seed, free in enumerate(maps)]
        for name in ("frontier-joint", "frontier-nearest")
    }
    assert sum(steps["frontier-joint"]) < 0.9 * sum(steps["frontier-nearest"])


def test_a_pocket_on_the_way_is_not_left_behind() -> None:
    free = np.zeros((9, 40), np.bool_)
    free[4, 1:39] = True
    free[1:4, 12] = free[5:8, 14] = True
    flight = fly(make_policy("frontier-joint"), free, spawns=[(4, 8)])
    columns = [col for _, col in flight.tracks[0]]
    assert flight.complete
    turns = np.flatnonzero(np.diff(np.sign(np.diff(columns))[np.diff(columns) != 0]))
    assert len(turns) <= 1


def test_it_tells_its_goal() -> None:
    flight = fly(make_policy("frontier-joint"), rooms(3, 5, 1), team=2, radio=("unlimited", 0.0), budget=12)
    for pilot in flight.pilots:
        assert pilot.message == message_of(pilot.goal)
