"""Straight segments on a belief map: the cells that they cross, and where they enter unknown space.

Points are (row, column) floats in continuous cell coordinates: cell (r, c) covers [r, r + 1) x [c, c + 1)
and its centre is (r + .5, c + .5). Unknown cells count as passable.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.compiled import kernel

#: Results of :func:`trace` other than a cell: no unknown cell on the segment, or an obstacle.
ALL_KNOWN, BLOCKED = -1, -2


@kernel(entry=False)
def _crossing(start: float, delta: float, cell: int) -> float:
    """Return the share of a segment at which it leaves ``cell`` along one axis; infinity for never."""
    if delta > 0.0:
        return (cell + 1 - start) / delta
    if delta < 0.0:
        return (cell - start) / delta
    return np.inf


@kernel()
def trace(belief: np.ndarray, row: float, col: float, to_row: float, to_col: float) -> int:
    """Return the last known cell before a segment enters unknown space, as a flat index.

    ``ALL_KNOWN`` if the segment stays in known free cells, ``BLOCKED`` if it crosses an obstacle or
    leaves the map. The cells are traversed side by side (Amanatides & Woo 1987), so that consecutive ones
    are 4-adjacent and no segment passes between two obstacles that touch at a corner.
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
    """Write the cells of :func:`entries` to ``found`` (K,); return their number. ``known`` (K,) must be all True."""
    size = 0
    for k in range(1, vertices.shape[0]):
        parent = parents[k]
        entry = trace(belief, vertices[parent, 0], vertices[parent, 1], vertices[k, 0], vertices[k, 1])
        known[k] = known[parent] and entry == ALL_KNOWN
        if known[parent] and entry >= 0:
            found[size] = entry
            size += 1
    return size


def entries(belief: Belief, vertices: NDArray[np.float64], parents: NDArray[np.int64]) -> NDArray[np.int32]:
    """Return the cells from which the branches of a tree first enter unknown space, as sorted flat indices.

    ``vertices`` is (K, 2) and ``parents`` (K,), each parent before its children and the root's -1, as
    :func:`indoor_explorers.planners.sampling.trees.grow_tree` returns them. The remainder of such a branch is
    ignored.
    """
    known, found = np.ones(len(vertices), np.bool_), np.empty(len(vertices), np.int32)
    return np.unique(found[: _entries(belief, vertices, parents, known, found)])
