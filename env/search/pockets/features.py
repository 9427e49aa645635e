"""What the pocket network sees of a frontier cluster: two square pictures of the map around it, and two numbers.

The pictures are centred on the mean of the cluster's cells. The fine one has ``SIDE`` x ``SIDE`` cells, the coarse one
``SIDE`` x ``SIDE`` blocks of ``BLOCK`` x ``BLOCK`` cells. Off the map counts as occupied.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, MOVES, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.search.clusters import Clusters

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
    """What the network sees of K clusters."""

    fine: NDArray[np.uint8]
    """(K, FINE_LAYERS, SIDE, SIDE): 0 or 1, the last layer 0 to 255."""
    coarse: NDArray[np.uint8]
    """(K, COARSE_LAYERS, SIDE, SIDE): 0 to 9."""
    numbers: NDArray[np.float32]
    """(K, 2): log(1 + cells of the cluster) / 3, and lidar range / 10."""


@kernel(entry=False)
def _sums(belief: np.ndarray, value: np.uint8) -> np.ndarray:
    """Return how many cells above and left of each corner hold a value, (H + 1, W + 1)."""
    height, width = belief.shape
    sums = np.zeros((height + 1, width + 1), np.int32)
    for row in range(height):
        line = 0
        for col in range(width):
            line += belief[row, col] == value
            sums[row + 1, col + 1] = sums[row, col + 1] + line
    return sums


@kernel(entry=False)
def _counted(sums: np.ndarray, top: int, left: int) -> tuple[int, int]:
    """Return how many cells of a block hold the value, and how many are on the map."""
    height, width = sums.shape
    r0, r1 = min(max(top, 0), height - 1), min(max(top + BLOCK, 0), height - 1)
    c0, c1 = min(max(left, 0), width - 1), min(max(left + BLOCK, 0), width - 1)
    return sums[r1, c1] - sums[r0, c1] - sums[r1, c0] + sums[r0, c0], (r1 - r0) * (c1 - c0)


@kernel(entry=False)
def _draw_near(belief: np.ndarray, cells: np.ndarray, top: int, left: int, out: np.ndarray) -> None:
    """Draw how near cells of the picture are to a cluster through unknown cells."""
    height, width = belief.shape
    queue, steps = np.empty(SIDE * SIDE, np.int32), np.zeros((SIDE, SIDE), np.int32)
    head, tail = 0, 0
    for cell in cells:
        row, col = cell // width - top, cell % width - left
        if 0 <= row < SIDE and 0 <= col < SIDE:
            queue[tail] = row * SIDE + col
            tail += 1
    while head < tail:
        row, col = divmod(queue[head], SIDE)
        head += 1
        if steps[row, col] == NEAR:
            break
        for move in range(4):
            r, c = row + MOVES[move, 0], col + MOVES[move, 1]
            if not (0 <= r < SIDE and 0 <= c < SIDE and 0 <= r + top < height and 0 <= c + left < width):
                continue
            if belief[r + top, c + left] == UNKNOWN and steps[r, c] == 0:
                steps[r, c] = steps[row, col] + 1
                out[r, c] = np.uint8(255.0 * np.exp(-(steps[r, c] - 1) / FADE))
                queue[tail] = r * SIDE + c
                tail += 1


@kernel(entry=False)
def _draw_cells(belief: np.ndarray, top: int, left: int, out: np.ndarray) -> None:
    height, width = belief.shape
    for row in range(SIDE):
        for col in range(SIDE):
            r, c = row + top, col + left
            value = belief[r, c] if 0 <= r < height and 0 <= c < width else np.uint8(OCCUPIED)
            out[0, row, col] = value == FREE
            out[1, row, col] = value == OCCUPIED
            out[3, row, col] = value == UNKNOWN


@kernel()
def _pictures(belief: np.ndarray, cells: np.ndarray, ends: np.ndarray, fine: np.ndarray, coarse: np.ndarray) -> None:
    width = belief.shape[1]
    free, occupied = _sums(belief, np.uint8(FREE)), _sums(belief, np.uint8(OCCUPIED))
    for k in range(ends.shape[0] - 1):
        own = cells[ends[k] : ends[k + 1]]
        row_sum, col_sum = 0, 0
        for cell in own:
            row_sum += cell // width
            col_sum += cell % width
        row, col = int(np.round(row_sum / own.shape[0])), int(np.round(col_sum / own.shape[0]))
        top, left = row - SIDE // 2, col - SIDE // 2
        _draw_cells(belief, top, left, fine[k])
        _draw_near(belief, own, top, left, fine[k, 4])
        for cell in own:
            r, c = cell // width - top, cell % width - left
            if 0 <= r < SIDE and 0 <= c < SIDE:
                fine[k, 2, r, c] = 1
        for r in range(SIDE):
            for c in range(SIDE):
                y, x = row + (r - SIDE // 2) * BLOCK - BLOCK // 2, col + (c - SIDE // 2) * BLOCK - BLOCK // 2
                coarse[k, 0, r, c], _ = _counted(free, y, x)
                known, inside = _counted(occupied, y, x)
                coarse[k, 1, r, c] = known + BLOCK * BLOCK - inside


def pictures(belief: Belief, clusters: Clusters, lidar_range: float) -> Pictures:
    """Return what the network sees of each of K clusters of a (H, W) belief."""
    count = clusters.size
    fine = np.zeros((count, FINE_LAYERS, SIDE, SIDE), np.uint8)
    coarse = np.zeros((count, COARSE_LAYERS, SIDE, SIDE), np.uint8)
    _pictures(belief, clusters.cells, clusters.ends, fine, coarse)
    numbers = np.empty((count, 2), np.float32)
    numbers[:, 0] = np.log1p(np.diff(clusters.ends)) / 3.0
    numbers[:, 1] = lidar_range / 10.0
    return Pictures(fine, coarse, numbers)
