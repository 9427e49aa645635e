from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import InputError, make_policy
from indoor_explorers.planners.teammates import message_of
from tests.planners.flights import fly, rooms


def test_it_needs_fewer_steps_than_the_nearest_frontier() -> None:
    halls = [rooms(3, 9, seed) for seed in range(4)]
    maps = [*halls, *(np.ones((16, 16), np.bool_),) * 4]
    steps = {
        name: [fly(make_policy(name), free, seed=seed).steps for seed, free in enumerate(maps)]
        for name in ("frontier-joint", "frontier-nearest")
    }
    assert sum(steps["frontier-joint"]) < 0.9 * sum(steps["frontier-nearest"])


def test_four_at_a_crossing_take_a_corridor_each() -> None:
    free = np.zeros((43, 43), np.bool_)
    free[21, 1:42] = free[1:42, 21] = True
    spawns = [(21, 21), (20, 21), (21, 20), (22, 21)]
    flight = fly(make_policy("frontier-joint"), free, team=4, radio=("unlimited", 0.0), spawns=spawns)
    ends = {(int(np.sign(row - 21)), int(np.sign(col - 21))) for row, col in (track[-1] for track in flight.tracks)}
    assert ends == {(0, 1), (0, -1), (1, 0), (-1, 0)}
    assert flight.steps <= 25


@pytest.mark.parametrize("radio", [("none", 0.0), ("disc", 4.0), ("unlimited", 0.0)], ids=lambda radio: radio[0])
def test_nobody_idles_or_dithers(radio: tuple[str, float]) -> None:
    flight = fly(make_policy("frontier-joint"), rooms(3, 5, 2), team=4, radio=radio)
    stays = sum(row.count(4) for row in flight.actions)
    assert flight.complete
    assert stays <= 0.1 * 4 * flight.steps  # who cannot hear the others waits for them in doorways
    assert flight.longest_dither <= 6


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


@pytest.mark.parametrize("name", ["fade", "rate", "latency", "clusters", "firsts"])
def test_bad_parameters_are_refused(name: str) -> None:
    with pytest.raises(InputError, match=f"expected {name} of at least"):
        make_policy("frontier-joint", **{name: -1.0})
