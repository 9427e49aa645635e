"""What viewpoints promise: unknown cells in view, the near and the isolated ones counting most.

The promise of a cell is the sum of w e^(-r / l) over the unknown cells visible from it, unknown ones taken as
transparent: r is how far away a cell is, as what lies farther behind the edge of the known is less likely to be in
view or free at all; w = 1 + a k / 24 is its isolation, k the cells of its 5x5 that are known or off the map: pockets
are worth finishing while they are near.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Belief
from indoor_explorers.env.compiled import leaf
from indoor_explorers.env.grid import UNKNOWN
from indoor_explorers.env.lidar import Optics, Scan, new_scan, optics, visible_cells

#: Known cells of a 5x5 around an unknown one are counted so far away.
NEAR = 2


class Memory(NamedTuple):
    """What is kept from one decision to the next; -1 where nothing is."""

    promises: NDArray[np.float64]
    """(H, W) promise of each cell."""
    before: Belief
    """(H, W) belief that they were computed on."""


@leaf()
def _isolation(belief: np.ndarray, row: int, col: int) -> float:
    """Return the share of the 24 cells around an unknown one that are known or off the map."""
    height, width = belief.shape
    unknown = 0
    for r in range(max(0, row - NEAR), min(height, row + NEAR + 1)):
        for c in range(max(0, col - NEAR), min(width, col + NEAR + 1)):
            unknown += belief[r, c] == UNKNOWN
    return (25 - unknown) / 24.0


@leaf()
def _promise(
    belief: np.ndarray, row: int, col: int, isolation: float, decay: np.ndarray, lens: Optics, scan: Scan
) -> float:
    width = belief.shape[1]
    total = 0.0
    for k in range(visible_cells(belief, row, col, lens, scan)):
        r, c = divmod(scan.cells[k], width)
        if belief[r, c] == UNKNOWN:
            total += (1.0 + isolation * _isolation(belief, r, c)) * decay[abs(r - row), abs(c - col)]
    return total


@leaf()
def _forget(belief: np.ndarray, memory: Memory, reach: int) -> None:
    """Drop the promises of all cells near enough to a change of the map to have changed with it."""
    height, width = belief.shape
    top, bottom, left, right = height, -1, width, -1
    for row in range(height):
        for col in range(width):
            if memory.before[row, col] != belief[row, col]:
                memory.before[row, col] = belief[row, col]
                top, bottom = min(top, row), max(bottom, row)
                left, right = min(left, col), max(right, col)
    for row in range(max(0, top - reach), min(height, bottom + reach + 1)):
        for col in range(max(0, left - reach), min(width, right + reach + 1)):
            memory.promises[row, col] = -1.0


@leaf()
def _promises(
    belief: np.ndarray,
    cells: np.ndarray,
    isolation: float,
    decay: np.ndarray,
    lens: Optics,
    scan: Scan,
    memory: Memory,
    found: np.ndarray,
) -> None:
    _forget(belief, memory, decay.shape[0] + NEAR)
    for k in range(cells.shape[0]):
        row, col = divmod(cells[k], belief.shape[1])
        if memory.promises[row, col] < 0.0:
            memory.promises[row, col] = _promise(belief, row, col, isolation, decay, lens, scan)
        found[k] = memory.promises[row, col]


class Promises:
    """Answer one pilot's questions about promises, and compute again only what the map's growth has changed."""

    def __init__(self, shape: tuple[int, int], lidar_range: float, isolation: float, depth: float) -> None:
        """Prepare for (H, W) maps; ``isolation`` is a of the weight, ``depth`` l in lidar ranges."""
        self._isolation = float(isolation)
        self._lens = optics(float(lidar_range))
        away = np.arange(int(lidar_range) + 2)
        self._decay = np.exp(-np.hypot(away[:, None], away[None]) / (depth * lidar_range))
        self._memory = Memory(np.full(shape, -1.0), np.zeros(shape, np.uint8))
        self._scan = new_scan(self._lens)

    def of(self, belief: Belief, cells: NDArray[np.int32]) -> NDArray[np.float64]:
        """Return the promises of (K,) flat cells on a (H, W) belief that has only grown since the last time."""
        found = np.empty(len(cells))
        _promises(belief, cells, self._isolation, self._decay, self._lens, self._scan, self._memory, found)
        return found
