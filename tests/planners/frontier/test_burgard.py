from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env import Mate
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.sensing.lidar import scan
from indoor_explorers.planners.frontier.burgard import FrontierBurgard, nearness
from tests.planners.flights import view_of

from .test_group_pilot import corridor, pilot_of


@pytest.mark.parametrize("reach", [1.0, 3.0, 6.5])
def test_nearness_falls_with_distance_and_behind_what_a_scan_cannot_see(belief: Belief, reach: float) -> None:
    cells = np.arange(belief.size, dtype=np.int32)
    origin = int(np.flatnonzero(belief == 1)[-1])
    transparent = np.where(belief == 2, 2, 1).astype(np.uint8)
    row, col = divmod(origin, belief.shape[1])
    seen = scan(transparent, (row, col), reach).ravel() > 0
    away = np.hypot(cells // belief.shape[1] - row, cells % belief.shape[1] - col)
    expected = np.where(seen, np.maximum(0, 1 - away / reach), 0.0)
    np.testing.assert_allclose(nearness(belief, origin, cells, reach), expected)


def test_the_second_uav_turns_to_where_the_first_does_not_look() -> None:
    belief = np.ones((9, 9), np.uint8)
    belief[0], belief[8] = 0, 0
    cells, rows = [(3, 4), (4, 4)], []
    for agent in (0, 1):
        pilot = pilot_of(FrontierBurgard(), agent, (9, 9))
        pilot.act(view_of(belief, cells[agent], (Mate(1 - agent, cells[1 - agent], 0, None),)))
        assert pilot.goal is not None
        rows.append(pilot.goal[0])
    assert rows == [1, 7]


def test_without_weight_both_take_the_nearest() -> None:
    cells = [(0, 7), (0, 8)]
    for agent in (0, 1):
        pilot = pilot_of(FrontierBurgard(weight=0.0), agent, (1, 20))
        pilot.act(view_of(corridor(), cells[agent], (Mate(1 - agent, cells[1 - agent], 0, None),)))
        assert pilot.goal == (0, 5)
