from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import make_policy
from tests.planners.flights import fly, rooms


def test_a_pocket_on_the_way_is_not_left_behind() -> None:
    free = np.zeros((9, 40), np.bool_)
    free[4, 1:39] = True
    free[1:4, 12] = free[5:8, 14] = True
    flight = fly(make_policy("frontier-joint"), free, spawns=[(4, 8)])
    columns = [col for _, col in flight.tracks[0]]
    assert flight.complete
    turns = np.flatnonzero(np.diff(np.sign(np.diff(columns))[np.diff(columns) != 0]))
    assert len(turns) <= 1


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
    assert stays <= 0.05 * 4 * flight.steps  # who cannot hear the others waits for them in doorways
    assert flight.longest_dither <= 6


def test_without_radio_a_team_parts_ways() -> None:
    free = np.ones((30, 30), np.bool_)
    spawns = [(15, 15), (15, 16), (16, 15), (16, 16)]
    steps = {
        name: sum(fly(make_policy(name), free, team=4, spawns=spawns, seed=seed).steps for seed in range(3))
        for name in ("frontier-nearest", "frontier-joint")
    }
    assert steps["frontier-joint"] < 0.8 * steps["frontier-nearest"]
