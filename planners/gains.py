"""What a scan at a cell could reveal: view gains on a belief map, unknown cells taken as transparent."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Belief
from indoor_explorers.env.compiled import kernel
from indoor_explorers.env.grid import UNKNOWN
from indoor_explorers.env.lidar import Optics, new_scan, optics, visible_cells
from indoor_explorers.env.sights import bit_count as bit_count  # planners count the bits of the sets made here


@kernel()
def _unclaimed(belief: np.ndarray, cells: np.ndarray, claims: np.ndarray, radius: float, lens: Optics) -> np.ndarray:
    width = belief.shape[1]
    scan = new_scan(lens)
    gains = np.zeros(cells.shape[0], np.int64)
    for k in range(cells.shape[0]):
        for place in range(visible_cells(belief, cells[k] // width, cells[k] % width, lens, scan)):
            row, col = divmod(scan.cells[place], width)
            counts = belief[row, col] == UNKNOWN
            for m in range(claims.shape[0]):
                rows, cols = row - claims[m, 0], col - claims[m, 1]
                counts &= rows * rows + cols * cols > radius * radius
            gains[k] += counts
    return gains


def unclaimed_gains(
    belief: Belief, cells: NDArray[np.int32], claims: NDArray[np.float64], lidar_range: float
) -> NDArray[np.int64]:
    """Return how many unknown cells are visible from each of (K,) flat cells and from no claim, (K,).

    ``claims`` is (M, 2) rows and columns; what is within the lidar range of a claim is left to whoever made it.
    """
    return np.asarray(_unclaimed(belief, cells, claims, lidar_range, optics(float(lidar_range))))


@kernel()
def _sights(belief: np.ndarray, cells: np.ndarray, lens: Optics) -> tuple[np.ndarray, int]:
    width = belief.shape[1]
    scan = new_scan(lens)
    number = np.full(belief.size, -1, np.int64)
    lists = np.empty((cells.shape[0], lens.disc + 1), np.int64)
    sizes = np.zeros(cells.shape[0], np.int64)
    total = 0
    for k in range(cells.shape[0]):
        for place in range(visible_cells(belief, cells[k] // width, cells[k] % width, lens, scan)):
            cell = scan.cells[place]
            if belief[cell // width, cell % width] == UNKNOWN:
                if number[cell] < 0:
                    number[cell] = total
                    total += 1
                lists[k, sizes[k]] = number[cell]
                sizes[k] += 1
    bits = np.zeros((cells.shape[0], (total + 63) // 64), np.uint64)
    for k in range(cells.shape[0]):
        for place in range(sizes[k]):
            bits[k, lists[k, place] // 64] |= np.uint64(1) << np.uint64(lists[k, place] % 64)
    return bits, total


def sights(belief: Belief, cells: NDArray[np.int32], lidar_range: float) -> NDArray[np.uint64]:
    """Return the sets of unknown cells visible from each of (K,) flat cells as bits, (K, words) uint64.

    Unknown cells are numbered in the order they are met; a set of bits ored together is a joint view.
    """
    return np.asarray(_sights(belief, cells, optics(float(lidar_range)))[0])
