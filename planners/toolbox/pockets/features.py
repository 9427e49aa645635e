"""Inputs of the pocket network for a frontier cluster: two square pictures of the map around it, and two numbers.

The pictures are centred on the mean of the cluster's cells. The fine one has ``SIDE`` x ``SIDE`` cells, the coarse one
``SIDE`` x ``SIDE`` blocks of ``BLOCK`` x ``BLOCK`` cells. Off the map counts as occupied.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters

#: Cells, or blocks, along a side of a picture; odd.
SIDE = 25
#: Cells along a side of a block; odd.
BLOCK = 3
#: Layers of the fine picture: free, occupied, this cluster, unknown, near it through the unknown (255 to 0).
FINE_LAYERS = 5
#: Layers of the coarse picture: numbers of free and of occupied cells of a block.
COARSE_LAYERS = 2
#: Steps through the unknown up to which cells count as near, and over which the nearness falls to 1 / e.
NEAR, FADE = 16, 6.0


class Pictures(NamedTuple):
    """Inputs of the network for K clusters."""

    fine: NDArray[np.uint8]
    """(K, FINE_LAYERS, SIDE, SIDE): 0 or 1, the last layer 0 to 255."""
    coarse: NDArray[np.uint8]
    """(K, COARSE_LAYERS, SIDE, SIDE): 0 to 9."""
    numbers: NDArray[np.float32]
    """(K, 2): log(1 + cells of the cluster) / 3, and lidar range / 10."""


#: In a sum of cells, a free one counts 1 and an occupied one this much.
_OCCUPIED_BIT = 32
_ONE_OCCUPIED = 1 << _OCCUPIED_BIT


@kernel(entry=False)
def _sums(belief: np.ndarray) -> np.ndarray:
    """Return the cells above and left of each corner, (H + 1, W + 1): free ones, and occupied ones above bit 32."""
    height, width = belief.shape
    sums = np.zeros((height + 1, width + 1), np.int64)
    for row in range(height):
        line = 0
        for col in range(width):
            line += (belief[row, col] == FREE) + (belief[row, col] == OCCUPIED) * _ONE_OCCUPIED
            sums[row + 1, col + 1] = sums[row, col + 1] + line
    return sums


@kernel(entry=False)
def _draw_blocks(sums: np.ndarray, top: int, left: int, out: np.ndarray) -> None:
    """Count the free and the occupied cells of each block."""
    rows, cols = np.empty(SIDE + 1, np.int64), np.empty(SIDE + 1, np.int64)
    for place in range(SIDE + 1):
        rows[place] = min(max(top + place * BLOCK, 0), sums.shape[0] - 1)
        cols[place] = min(max(left + place * BLOCK, 0), sums.shape[1] - 1)
    for r in range(SIDE):
        above, below = sums[rows[r]], sums[rows[r + 1]]
        for c in range(SIDE):
            known = below[cols[c + 1]] - above[cols[c + 1]] - below[cols[c]] + above[cols[c]]
            inside = (rows[r + 1] - rows[r]) * (cols[c + 1] - cols[c])
            out[0, r, c] = known & (_ONE_OCCUPIED - 1)
            out[1, r, c] = (known >> _OCCUPIED_BIT) + BLOCK * BLOCK - inside


@kernel(entry=False)
def _draw_cells(belief: np.ndarray, top: int, left: int, out: np.ndarray) -> None:
    """Draw which cells are free, occupied or off the map, and unknown."""
    height, width = belief.shape
    first, last = min(max(-left, 0), SIDE), min(max(width - left, 0), SIDE)
    out[1] = 1
    for row in range(max(-top, 0), min(height - top, SIDE)):
        for col in range(first, last):
            value = belief[row + top, col + left]
            out[0, row, col] = value == FREE
            out[1, row, col] = value == OCCUPIED
            out[3, row, col] = value == UNKNOWN


#: Cells along a side of a picture with a border.
_PITCH = SIDE + 2


@kernel(entry=False)
def _draw_near(cells: np.ndarray, unknown: np.ndarray, nearness: np.ndarray, out: np.ndarray) -> None:
    """Draw how near ``unknown`` cells are to a cluster's ``cells`` through them; ``nearness`` by steps."""
    left = np.zeros(_PITCH * _PITCH, np.uint8)
    queue = np.empty(SIDE * SIDE, np.int32)
    head, tail = 0, 0
    for row in range(SIDE):
        for col in range(SIDE):
            place = (row + 1) * _PITCH + col + 1
            left[place] = unknown[row, col]
            if cells[row, col]:
                queue[tail] = place
                tail += 1
    for steps in range(1, NEAR + 1):
        last = tail
        for k in range(head, last):
            for beside in (queue[k] + _PITCH, queue[k] - 1, queue[k] - _PITCH, queue[k] + 1):
                if left[beside]:
                    left[beside] = 0
                    out[beside // _PITCH - 1, beside % _PITCH - 1] = nearness[steps]
                    queue[tail] = beside
                    tail += 1
        head = last


@kernel()
def _pictures(belief: np.ndarray, cells: np.ndarray, ends: np.ndarray, fine: np.ndarray, coarse: np.ndarray) -> None:
    width = belief.shape[1]
    sums, nearness = _sums(belief), np.zeros(NEAR + 1, np.uint8)
    for steps in range(1, NEAR + 1):
        nearness[steps] = np.uint8(255.0 * np.exp(-(steps - 1) / FADE))
    for k in range(ends.shape[0] - 1):
        own = cells[ends[k] : ends[k + 1]]
        row_sum, col_sum = 0, 0
        for cell in own:
            row_sum += cell // width
            col_sum += cell % width
        row, col = int(np.round(row_sum / own.shape[0])), int(np.round(col_sum / own.shape[0]))
        top, left = row - SIDE // 2, col - SIDE // 2
        _draw_cells(belief, top, left, fine[k])
        for cell in own:
            r, c = cell // width - top, cell % width - left
            if 0 <= r < SIDE and 0 <= c < SIDE:
                fine[k, 2, r, c] = 1
        _draw_near(fine[k, 2], fine[k, 3], nearness, fine[k, 4])
        middle = SIDE // 2 * BLOCK + BLOCK // 2
        _draw_blocks(sums, row - middle, col - middle, coarse[k])


def pictures(belief: Belief, clusters: Clusters, lidar_range: float) -> Pictures:
    """Return the inputs of the network for each of K clusters of a (H, W) belief."""
    count = clusters.size
    fine = np.zeros((count, FINE_LAYERS, SIDE, SIDE), np.uint8)
    coarse = np.zeros((count, COARSE_LAYERS, SIDE, SIDE), np.uint8)
    _pictures(belief, clusters.cells, clusters.ends, fine, coarse)
    numbers = np.empty((count, 2), np.float32)
    numbers[:, 0] = np.log1p(np.diff(clusters.ends)) / 3.0
    numbers[:, 1] = lidar_range / 10.0
    return Pictures(fine, coarse, numbers)
