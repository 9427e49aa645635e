from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env.arrays import Belief
from indoor_explorers.env.grid import FREE, UNKNOWN
from indoor_explorers.env.lidar import new_scan, optics, view_gain, visible_cells
from indoor_explorers.planners.sampling.views import Promises


def promise(belief: Belief, cell: int, lidar_range: float, isolation: float, depth: float) -> float:
    """The definition, word for word."""
    lens = optics(lidar_range)
    scan = new_scan(lens)
    row, col = divmod(cell, belief.shape[1])
    known = np.pad(belief != UNKNOWN, 2, constant_values=True)
    total = 0.0
    for seen in set(scan.cells[: visible_cells(belief, row, col, lens, scan)].tolist()):
        r, c = divmod(seen, belief.shape[1])
        if belief[r, c] == UNKNOWN:
            weight = 1.0 + isolation * known[r : r + 5, c : c + 5].sum() / 24
            total += weight * np.exp(-np.hypot(r - row, c - col) / (depth * lidar_range))
    return total


@pytest.mark.parametrize("lidar_range", [1.0, 3.0, 5.5])
def test_promises_are_what_they_say(belief: Belief, lidar_range: float) -> None:
    cells = np.flatnonzero(belief == FREE).astype(np.int32)
    found = Promises(belief.shape, lidar_range, 8.0, 0.5).of(belief, cells)
    assert found == pytest.approx([promise(belief, cell, lidar_range, 8.0, 0.5) for cell in cells.tolist()])


def test_without_weights_a_promise_is_the_view_gain(belief: Belief) -> None:
    cells = np.flatnonzero(belief == FREE).astype(np.int32)
    found = Promises(belief.shape, 3.0, 0.0, 1e12).of(belief, cells)
    assert found == pytest.approx([view_gain(belief, divmod(cell, belief.shape[1]), 3.0) for cell in cells.tolist()])


@pytest.mark.parametrize("seed", range(5))
def test_what_is_remembered_is_what_would_be_computed(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = np.where(rng.random((30, 25)) < 0.2, 2, 1).astype(np.uint8)
    belief = np.zeros_like(truth)
    kept = Promises(belief.shape, 4.0, 8.0, 0.5)
    for _ in range(12):
        row, col = int(rng.integers(26)), int(rng.integers(21))
        belief[row : row + 5, col : col + 5] = truth[row : row + 5, col : col + 5]
        cells = np.flatnonzero(belief == FREE).astype(np.int32)
        some = rng.choice(cells, min(40, len(cells)), replace=False)
        assert (kept.of(belief, some) == Promises(belief.shape, 4.0, 8.0, 0.5).of(belief, some)).all()
