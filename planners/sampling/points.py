"""Points of trees and roadmaps: continuous coordinates on a plain map, or in a volume of several levels.

A point has D axes: row and column, or level, row and column on maps of several levels, whose ``rise`` is not 0
(:mod:`indoor_explorers.env.grid.levels`). Cell (r, c) covers [r, r + 1) x [c, c + 1) and its centre is
(r + .5, c + .5); levels are one cell high.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.grid.levels import coordinates

#: (K, D) coordinates.
Points = NDArray[np.float64]


def extent(shape: tuple[int, ...], rise: int) -> tuple[int, ...]:
    """Return the cells of a (H, W) plane along each of the D axes."""
    return ((shape[0] + 1) // rise, rise - 1, shape[1]) if rise > 0 else shape


def centre(cell: Cell, rise: int) -> tuple[float, ...]:
    """Return the coordinates of the centre of a cell of the plane, (D,)."""
    row, col = cell
    return (row // rise + 0.5, row % rise + 0.5, col + 0.5) if rise > 0 else (row + 0.5, col + 0.5)


def points_in(cells: NDArray[np.int32], width: int, rise: int, rng: np.random.Generator) -> Points:
    """Draw one point in each of (K,) flat cells, (K, D)."""
    begin = coordinates(cells, width, rise)
    return begin + rng.random(begin.shape)


def known_cells(belief: Belief, points: Points, rise: int) -> NDArray[np.int32]:
    """Return the flat cells of (K, D) points, (K,), -1 where they are not known to be free."""
    inside = np.minimum(np.floor(points).astype(np.int64), np.array(extent(belief.shape, rise)) - 1)
    rows, cols = inside[:, -2], inside[:, -1]
    if rise > 0:
        rows = rows + rise * inside[:, 0]
    return np.where(belief[rows, cols] == FREE, rows * belief.shape[1] + cols, -1).astype(np.int32)


def lengths(vectors: NDArray[np.floating | np.integer]) -> NDArray[np.float64]:
    """Return the Euclidean lengths (K,) of (K, D) vectors."""
    return np.asarray(np.hypot.reduce(vectors, axis=1), np.float64)


def distances_to(cells: NDArray[np.int32], cell: Cell, width: int, rise: int) -> NDArray[np.float64]:
    """Return the straight distances from (K,) flat cells to a cell of the plane, (K,)."""
    return lengths(coordinates(cells, width, rise) - coordinates(np.array([cell[0] * width + cell[1]]), width, rise))
