"""Straight segments on a belief map: the cells that they cross, and where they enter unknown space.

Points are those of :mod:`indoor_explorers.planners.sampling.points`. Unknown cells count as passable. A plain map is
traced as a volume of one level, by the same code.
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
def _crossing(start: float, end: float, cell: int, last: int) -> float:
    """Return the share of a segment at which it leaves ``cell`` along one axis; infinity in the ``last`` one."""
    if cell == last:
        return np.inf
    return (cell + (end > start) - start) / (end - start)


@kernel()
def trace(
    belief: np.ndarray,
    row: float,
    col: float,
    to_row: float,
    to_col: float,
    rise: int = 0,
    level: float = 0.0,
    to_level: float = 0.0,
) -> int:
    """Return the last known cell before a segment enters unknown space, as a flat index.

    ``ALL_KNOWN`` if the segment stays in known free cells, ``BLOCKED`` if it crosses an obstacle or
    leaves the map. The cells are traversed side by side (Amanatides & Woo 1987), so that consecutive ones
    are adjacent and no segment passes between two obstacles that touch at an edge or a corner.
    """
    height, width = belief.shape[0] if rise == 0 else rise - 1, belief.shape[1]
    count = 1 if rise == 0 else (belief.shape[0] + 1) // rise
    k, r, c = int(np.floor(level)), int(np.floor(row)), int(np.floor(col))
    last_k, last_r, last_c = int(np.floor(to_level)), int(np.floor(to_row)), int(np.floor(to_col))
    if not (0 <= r < height and 0 <= c < width and 0 <= last_r < height and 0 <= last_c < width):
        return BLOCKED
    if not (0 <= k < count and 0 <= last_k < count):
        return BLOCKED
    up, down, right = (1 if to_level > level else -1), (1 if to_row > row else -1), (1 if to_col > col else -1)
    entry, before = ALL_KNOWN, -1
    for _ in range(abs(last_k - k) + abs(last_r - r) + abs(last_c - c) + 1):
        cell = belief[k * rise + r, c]
        if cell == OCCUPIED:
            return BLOCKED
        if cell == UNKNOWN and entry == ALL_KNOWN:
            entry = before
        if cell == FREE:
            before = (k * rise + r) * width + c
        on_level, on_row = _crossing(level, to_level, k, last_k), _crossing(row, to_row, r, last_r)
        on_col = _crossing(col, to_col, c, last_c)
        if on_level <= on_row and on_level <= on_col:
            k += up
        elif on_row <= on_col:
            r += down
        else:
            c += right
    return entry


@kernel()
def _entries(
    belief: np.ndarray, vertices: np.ndarray, parents: np.ndarray, rise: int, known: np.ndarray, found: np.ndarray
) -> int:
    """Write the cells of :func:`entries` to ``found`` (K,); return their number. ``known`` (K,) must be all True."""
    size = 0
    for k in range(1, vertices.shape[0]):
        start, end = vertices[parents[k]], vertices[k]
        level, to_level = (start[0], end[0]) if rise > 0 else (0.0, 0.0)
        entry = trace(belief, start[-2], start[-1], end[-2], end[-1], rise, level, to_level)
        known[k] = known[parents[k]] and entry == ALL_KNOWN
        if known[parents[k]] and entry >= 0:
            found[size] = entry
            size += 1
    return size


def entries(
    belief: Belief, vertices: NDArray[np.float64], parents: NDArray[np.int64], rise: int = 0
) -> NDArray[np.int32]:
    """Return the cells from which the branches of a tree first enter unknown space, as sorted flat indices.

    ``vertices`` is (K, D) and ``parents`` (K,), each parent before its children and the root's -1, as
    :func:`indoor_explorers.planners.sampling.trees.grow_tree` returns them. The remainder of such a branch is
    ignored.
    """
    known, found = np.ones(len(vertices), np.bool_), np.empty(len(vertices), np.int32)
    return np.unique(found[: _entries(belief, vertices, parents, rise, known, found)])
