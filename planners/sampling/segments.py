"""Straight flights over a belief map: which cells a segment runs through, and where it meets the unknown.

Points are (row, column) floats in continuous cell coordinates: cell (r, c) covers [r, r + 1) x [c, c + 1)
and its centre is (r + .5, c + .5). Unknown cells are taken to be passable.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.compiled import kernel

#: What :func:`fly` answers beside a cell: nothing unknown on the way, or an obstacle.
ALL_KNOWN, BLOCKED = -1, -2


@kernel(entry=False)
def _crossing(start: float, delta: float, cell: int) -> float:
    """Return at which share of a segment it leaves ``cell`` along one axis; infinity for never."""
    if delta > 0.0:
        return (cell + 1 - start) / delta
    if delta < 0.0:
        return (cell - start) / delta
    return np.inf


@kernel()
def fly(belief: np.ndarray, row: float, col: float, to_row: float, to_col: float) -> int:
    """Return the last cell before the unknown on a segment, as a flat index.

    ``ALL_KNOWN`` when the segment stays in known free cells, ``BLOCKED`` when it runs through an obstacle or
    leaves the map. Cells are visited one side at a time (Amanatides & Woo 1987), so that consecutive ones
    are 4-adjacent and no flight slips between two obstacles that touch at a corner.
    """
    height, width = belief.shape
    r, c = int(np.floor(row)), int(np.floor(col))
    last_r, last_c = int(np.floor(to_row)), int(np.floor(to_col))
    if not (0 <= r < height and 0 <= c < width and 0 <= last_r < height and 0 <= last_c < width):
        return BLOCKED
    down, right = (1 if to_row > row else -1), (1 if to_col > col else -1)
    entry, before = ALL_KNOWN, -1
    for _ in range(abs(last_r - r) + abs(last_c - c) + 1):
        if belief[r, c] == OCCUPIED:
            return BLOCKED
        if belief[r, c] == UNKNOWN and entry == ALL_KNOWN:
            entry = before
        if belief[r, c] == FREE:
            before = r * width + c
        if c == last_c or (r != last_r and _crossing(row, to_row - row, r) <= _crossing(col, to_col - col, c)):
            r += down
        else:
            c += right
    return entry


@kernel()
def _entries(
    belief: np.ndarray, vertices: np.ndarray, parents: np.ndarray, known: np.ndarray, found: np.ndarray
) -> int:
    """Write the cells of :func:`entries` to ``found`` (K,); return how many. ``known`` (K,) is true at first."""
    size = 0
    for k in range(1, vertices.shape[0]):
        parent = parents[k]
        entry = fly(belief, vertices[parent, 0], vertices[parent, 1], vertices[k, 0], vertices[k, 1])
        known[k] = known[parent] and entry == ALL_KNOWN
        if known[parent] and entry >= 0:
            found[size] = entry
            size += 1
    return size


def entries(belief: Belief, vertices: NDArray[np.float64], parents: NDArray[np.int64]) -> NDArray[np.int32]:
    """Return the cells from which the edges of a tree first enter the unknown, as sorted flat indices.

    ``vertices`` is (K, 2) and ``parents`` (K,), each parent before its children and the root's -1, as
    :func:`indoor_explorers.planners.sampling.trees.grow_tree` returns them. Branches behind an entry are not
    looked at.
    """
    known, found = np.ones(len(vertices), np.bool_), np.empty(len(vertices), np.int32)
    return np.unique(found[: _entries(belief, vertices, parents, known, found)])
