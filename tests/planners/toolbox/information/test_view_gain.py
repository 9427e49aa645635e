from __future__ import annotations

import math

import numpy as np
import pytest

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, UNKNOWN
from indoor_explorers.env.sensing.lidar import lidar_model, new_scan, view_gain, visible_cells
from indoor_explorers.planners.toolbox.information.view_gain import WeightedGains, unclaimed_gains


def plain_gain(belief: Belief, cell: int, lidar_range: float, depth: float, isolation: float) -> float:
    height, width = belief.shape
    row, col = divmod(cell, width)
    lidar = lidar_model(lidar_range)
    scan = new_scan(lidar)
    seen = scan.cells[: visible_cells(belief, row, col, lidar, scan)].tolist()
    gain = 0.0
    for r, c in (divmod(place, width) for place in seen):
        if belief[r, c] == UNKNOWN:
            around = [(rr, cc) for rr in range(r - 2, r + 3) for cc in range(c - 2, c + 3) if (rr, cc) != (r, c)]
            inside = [(rr, cc) for rr, cc in around if 0 <= rr < height and 0 <= cc < width]
            closed = 24 - sum(int(belief[place] == UNKNOWN) for place in inside)
            gain += math.exp(-math.hypot(r - row, c - col) / (depth * lidar_range)) * (1 + isolation * closed / 24)
    return gain


@pytest.mark.parametrize("isolation", [0.0, 8.0])
def test_weighted_gains_are_what_they_say(belief: Belief, isolation: float) -> None:
    cells = np.flatnonzero(belief == 1).astype(np.int32)[:20]
    found = WeightedGains(belief.shape, 4.5, 0.5, isolation).at(belief, cells)
    assert found == pytest.approx([plain_gain(belief, cell, 4.5, 0.5, isolation) for cell in cells.tolist()])


def test_without_weights_they_are_the_view_gains(belief: Belief) -> None:
    cells = np.flatnonzero(belief == 1).astype(np.int32)[:20]
    found = WeightedGains(belief.shape, 3.0).at(belief, cells)
    assert found.tolist() == [view_gain(belief, divmod(cell, belief.shape[1]), 3.0) for cell in cells.tolist()]


def test_kept_gains_are_those_of_the_map_as_it_is() -> None:
    rng = np.random.default_rng(5)
    truth = np.where(rng.random((40, 50)) < 0.2, 2, 1).astype(np.uint8)
    belief = np.zeros(truth.shape, np.uint8)
    kept = WeightedGains(truth.shape, 4.0, 0.5, 8.0)
    for _ in range(25):
        for _ in range(2):
            row, col = int(rng.integers(36)), int(rng.integers(46))
            belief[row : row + 4, col : col + 4] = truth[row : row + 4, col : col + 4]
        cells = np.flatnonzero(belief == 1).astype(np.int32)[::3]
        assert kept.at(belief, cells).tolist() == WeightedGains(truth.shape, 4.0, 0.5, 8.0).at(belief, cells).tolist()


def test_the_old_name_of_the_decay_length_is_accepted() -> None:
    given: dict[str, float] = {"depth": 0.5}
    belief, cells = np.array([[1, 0, 0, 0]], np.uint8), np.array([0], np.int32)
    with pytest.warns(FutureWarning, match="WeightedGains: the parameter 'depth' is now 'decay_length'"):
        old = WeightedGains(belief.shape, 4.0, **given)
    assert old.at(belief, cells) == WeightedGains(belief.shape, 4.0, decay_length=0.5).at(belief, cells)


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
