"""Frontier cells: known free cells adjacent to unknown ones (B. Yamauchi 1997, doi:10.1109/CIRA.1997.613851).

A cell has four neighbours, and six on maps of several levels, whose ``rise`` is not 0
(:mod:`indoor_explorers.env.grid.levels`).
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.cells import FREE, UNKNOWN
from indoor_explorers.env.grid.compiled import kernel, leaf


@leaf(entry=False)
def touches_unknown(belief: np.ndarray, row: int, col: int, rise: int = 0) -> bool:
    """Tell whether a cell of a belief (H, W) uint8 is adjacent to an unknown one."""
    height, width = belief.shape
    return bool(
        (row > 0 and belief[row - 1, col] == UNKNOWN)
        or (col > 0 and belief[row, col - 1] == UNKNOWN)
        or (row + 1 < height and belief[row + 1, col] == UNKNOWN)
        or (col + 1 < width and belief[row, col + 1] == UNKNOWN)
        or (0 < rise <= row and belief[row - rise, col] == UNKNOWN)
        or (0 < rise < height - row and belief[row + rise, col] == UNKNOWN)
    )


@leaf()
def on_frontier(belief: np.ndarray, cell: int, rise: int = 0) -> bool:
    """Tell whether a flat cell of a belief (H, W) uint8 is a frontier cell."""
    row, col = divmod(cell, belief.shape[1])
    return bool(belief[row, col] == FREE and touches_unknown(belief, row, col, rise))


@kernel()
def frontier_mask(belief: np.ndarray, rise: int = 0) -> np.ndarray:
    """Return the (H, W) bool mask of frontier cells."""
    height, width = belief.shape
    mask = np.zeros((height, width), np.bool_)
    for r in range(height):
        for c in range(width):
            mask[r, c] = belief[r, c] == FREE and touches_unknown(belief, r, c, rise)
    return mask


@kernel()
def frontier_cells(belief: np.ndarray, cells: np.ndarray, rise: int = 0) -> np.ndarray:
    """Return which of (K,) flat cells are frontier cells, (K,) bool."""
    on = np.empty(cells.shape[0], np.bool_)
    for k in range(cells.shape[0]):
        on[k] = on_frontier(belief, cells[k], rise)
    return on
