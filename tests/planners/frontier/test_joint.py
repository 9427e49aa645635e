from __future__ import annotations

import numpy as np

from indoor_explorers.env import make_policy
from tests.planners.flights import fly


def test_a_pocket_on_the_way_is_not_left_behind() -> None:
    free = np.zeros((9, 40), np.bool_)
    free[4, 1:39] = True
    free[1:4, 12] = free[5:8, 14] = True
    flight = fly(make_policy("frontier-joint"), free, spawns=[(4, 8)])
    columns = [col for _, col in flight.tracks[0]]
    assert flight.complete
    turns = np.flatnonzero(np.diff(np.sign(np.diff(columns))[np.diff(columns) != 0]))
    assert len(turns) <= 1
