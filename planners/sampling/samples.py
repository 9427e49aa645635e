"""Samples for trees and roadmaps, drawn from the pilot's own generator."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE, UNKNOWN
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.grid.levels import beside, degree, offset
from indoor_explorers.planners.sampling.points import Points, centre, extent, points_in


def tree_samples(
    belief: Belief, cell: Cell, half: float, count: int, bias: float, rng: np.random.Generator, rise: int = 0
) -> Points:
    """Draw (count, D) points in the square or cube around a cell's centre, with half the side ``half``, on the map.

    A share ``bias`` of them is drawn from unknown cells next to known free ones; the others are uniform.
    """
    middle, size = np.array(centre(cell, rise)), np.array(extent(belief.shape, rise), np.float64)
    low, high = np.maximum(middle - half, 0.0), np.minimum(middle + half, size)
    points: Points = low + rng.random((count, len(size))) * (high - low)
    edge_of_unknown = border_cells(belief, low.astype(np.int64), np.ceil(high).astype(np.int64), rise)
    if len(edge_of_unknown):
        biased = min(count, int(bias * count))
        drawn = edge_of_unknown[rng.integers(len(edge_of_unknown), size=biased)]
        points[:biased] = points_in(drawn, belief.shape[1], rise, rng)
        points = rng.permutation(points)
    return points


@kernel()
def border_cells(belief: np.ndarray, low: np.ndarray, high: np.ndarray, rise: int = 0) -> np.ndarray:
    """Return the unknown cells adjacent to known free ones between two corners, each (D,); flat, (K,)."""
    height, width = belief.shape
    found = np.empty((high - low).prod(), np.int32)
    size = 0
    levels = range(low[0], high[0]) if rise > 0 else range(1)
    for level in levels:
        for row in range(level * rise + low[-2], level * rise + high[-2]):
            for col in range(low[-1], high[-1]):
                near = False
                for k in range(degree(rise) if belief[row, col] == UNKNOWN else 0):
                    r, c = beside(row, col, k, rise)
                    near |= 0 <= r < height and 0 <= c < width and belief[r, c] == FREE
                if near:
                    found[size] = row * width + col
                    size += 1
    return found[:size]


@kernel()
def merged(cells: np.ndarray, distance: float, width: int, most: int, rise: int = 0) -> np.ndarray:
    """Return the indices of at most ``most`` of (K,) flat cells, each at least ``distance`` from those before it."""
    kept = np.empty(min(most, cells.shape[0]), np.int64)
    size = 0
    for k in range(cells.shape[0]):
        if size == kept.shape[0]:
            break
        row, col = divmod(cells[k], width)
        apart = True
        for j in range(size):
            levels, rows, cols = offset(cells[kept[j]] // width, cells[kept[j]] % width, row, col, rise)
            apart &= levels * levels + rows * rows + cols * cols >= distance * distance
        if apart:
            kept[size] = k
            size += 1
    return kept[:size]
