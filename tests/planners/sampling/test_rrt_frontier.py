from __future__ import annotations

import numpy as np

from indoor_explorers.env import make_policy
from indoor_explorers.env.grid.cells import FREE, UNKNOWN
from indoor_explorers.env.sensing.lidar import view_gain
from indoor_explorers.planners.sampling.samples import border_cells, merged
from indoor_explorers.planners.toolbox.information.view_gain import unclaimed_gains
from tests.planners.flights import world_on


def test_near_candidates_are_merged() -> None:
    cells = np.array([0, 1, 2, 3, 4, 9, 30], np.int32)
    assert cells[merged(cells, 3.0, 10, len(cells))].tolist() == [0, 3, 9, 30]
    assert merged(cells[:0], 3.0, 10, 5).tolist() == []


def test_border_cells_are_unknown_beside_free() -> None:
    belief = np.array([[1, 0, 0, 1], [2, 0, 0, 0]], np.uint8)
    whole = np.array([0, 0]), np.array([2, 4])
    assert border_cells(belief, *whole).tolist() == [[0, 1], [0, 2], [1, 3]]
    assert border_cells(belief, np.array([0, 0]), np.array([1, 2])).tolist() == [[0, 1]]


def test_gains_near_claims_are_discounted() -> None:
    belief = np.zeros((9, 20), np.uint8)
    belief[:, :10] = FREE
    cells = np.array([4 * 20 + 9, 0 * 20 + 9], np.int32)
    nothing = np.empty((0, 2))
    free = unclaimed_gains(belief, cells, nothing, 3.0)
    assert free.tolist() == [view_gain(belief, (4, 9), 3.0), view_gain(belief, (0, 9), 3.0)]
    claimed = unclaimed_gains(belief, cells, np.array([[4.0, 9.0]]), 3.0)
    assert claimed[0] == 0
    assert 0 < claimed[1] < free[1]


def test_the_goal_is_told() -> None:
    world = world_on(np.ones((9, 9), np.bool_))
    pilot = make_policy("rrt-frontier").pilot(world.briefing(0, 0))
    assert pilot.message is None
    pilot.act(world.view(0, 0))
    assert pilot.message is not None
    row, col = map(int, pilot.message)
    belief = world.view(0, 0).belief
    assert belief[row, col] == FREE
    assert (belief[max(0, row - 1) : row + 2, max(0, col - 1) : col + 2] == UNKNOWN).any()
