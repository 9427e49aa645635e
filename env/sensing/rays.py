"""Rays of a scanning lidar: distances from the centre of a cell to the first obstacle in some directions.

Obstacles are squares, as in the exact lidar (:mod:`indoor_explorers.env.sensing.shadowcasting`), and its rule for
corners holds: touching the corner of one obstacle does not block, passing between two that touch at a corner does. So a
ray to the centre of a free cell within range reaches it if and only if the exact lidar sees that cell. Rays step from
border to border of the cells (Amanatides & Woo 1987, "A fast voxel traversal algorithm for ray tracing", Eurographics,
doi:10.2312/egtp.19871000).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import OCCUPIED

#: Tolerance of equal distances along a ray, in cells.
SAME = 1e-9


def first_hits(truth: Belief, cell: Cell, lidar_range: float, angles: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return (K,) distances in cells from the centre of ``cell`` to the first obstacle; inf where none is in range.

    Args:
        truth: (H, W) uint8, of which ``OCCUPIED`` blocks; there is nothing off the map.
        cell: row and column.
        lidar_range: cells.
        angles: (K,) radians, 0 along the columns, growing anticlockwise on a map with row 0 at its top.

    """
    ways = np.stack((-np.sin(angles), np.cos(angles)))
    turns = np.where(ways < 0, -1, 1)
    with np.errstate(divide="ignore", over="ignore"):
        apart = 1 / np.abs(ways)
    ahead, places = apart / 2, np.tile(np.array([cell]).T, len(angles))
    hits, going = np.full(len(angles), np.inf), np.arange(len(angles))
    while going.size:
        way, turn = ahead[:, going], turns[:, going]
        here = way.min(axis=0)
        crossed = way <= here + SAME
        before, after = places[:, going], places[:, going] + turn * crossed
        squeezed = crossed.all(axis=0) & _blocks(truth, before[0], after[1]) & _blocks(truth, after[0], before[1])
        in_range = here <= lidar_range + SAME
        hit = (squeezed | _blocks(truth, *after)) & in_range
        hits[going[hit]] = here[hit]
        places[:, going] = after
        ahead[:, going] += np.where(crossed, apart[:, going], 0.0)
        going = going[in_range & ~hit & _inside(truth, *after)]
    return hits


def _inside(truth: Belief, rows: NDArray[np.int64], cols: NDArray[np.int64]) -> NDArray[np.bool_]:
    return np.asarray((rows >= 0) & (rows < truth.shape[0]) & (cols >= 0) & (cols < truth.shape[1]))


def _blocks(truth: Belief, rows: NDArray[np.int64], cols: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which of the cells (K,) are obstacles on the map."""
    height, width = truth.shape
    found = truth[rows.clip(0, height - 1), cols.clip(0, width - 1)] == OCCUPIED
    return np.asarray(found & _inside(truth, rows, cols))
