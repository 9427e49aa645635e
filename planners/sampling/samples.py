"""Samples for trees and roadmaps, drawn from the pilot's own generator."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE, UNKNOWN
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.planners.sampling.setting import Points


def tree_samples(belief: Belief, cell: Cell, half: float, count: int, bias: float, rng: np.random.Generator) -> Points:
    """Draw (count, 2) points in the square around a cell's centre with half the side ``half``, clipped to the map.

    A share ``bias`` of them is drawn from unknown cells next to known free ones; the others are uniform.
    """
    centre = np.array(cell) + 0.5
    low, high = np.maximum(centre - half, 0.0), np.minimum(centre + half, np.array(belief.shape, np.float64))
    points: Points = low + rng.random((count, 2)) * (high - low)
    edge_of_unknown = border_cells(belief, low.astype(np.int64), np.ceil(high).astype(np.int64))
    if len(edge_of_unknown):
        biased = min(count, int(bias * count))
        drawn = edge_of_unknown[rng.integers(len(edge_of_unknown), size=biased)]
        points[:biased] = drawn + rng.random((biased, 2))
        points = rng.permutation(points)
    return points


def points_in(cells: NDArray[np.int32], width: int, rng: np.random.Generator) -> Points:
    """Draw one point in each of (K,) flat cells, (K, 2)."""
    return np.stack(np.divmod(cells, width), axis=1) + rng.random((len(cells), 2))


def known_cells(belief: Belief, points: Points) -> NDArray[np.int32]:
    """Return the flat cells of (K, 2) points, (K,), -1 where they are not known to be free."""
    rows, cols = np.minimum(np.floor(points).astype(np.int64), np.array(belief.shape) - 1).T
    return np.where(belief[rows, cols] == FREE, rows * belief.shape[1] + cols, -1).astype(np.int32)


@kernel()
def border_cells(belief: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the unknown cells 4-adjacent to known free ones between two corners, (K, 2) rows and columns."""
    height, width = belief.shape
    found = np.empty(((high[0] - low[0]) * (high[1] - low[1]), 2), np.int64)
    size = 0
    for row in range(low[0], high[0]):
        for col in range(low[1], high[1]):
            if belief[row, col] == UNKNOWN and (
                (row > 0 and belief[row - 1, col] == FREE)
                or (col > 0 and belief[row, col - 1] == FREE)
                or (row + 1 < height and belief[row + 1, col] == FREE)
                or (col + 1 < width and belief[row, col + 1] == FREE)
            ):
                found[size, 0], found[size, 1] = row, col
                size += 1
    return found[:size]


@kernel()
def merged(cells: np.ndarray, distance: float, width: int, most: int) -> np.ndarray:
    """Return the indices of at most ``most`` of (K,) flat cells, each at least ``distance`` from those before it."""
    kept = np.empty(min(most, cells.shape[0]), np.int64)
    size = 0
    for k in range(cells.shape[0]):
        if size == kept.shape[0]:
            break
        row, col = divmod(cells[k], width)
        apart = True
        for j in range(size):
            rows, cols = row - cells[kept[j]] // width, col - cells[kept[j]] % width
            apart &= rows * rows + cols * cols >= distance * distance
        if apart:
            kept[size] = k
            size += 1
    return kept[:size]
