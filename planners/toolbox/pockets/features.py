"""Inputs of the pocket network for a frontier cluster: two square pictures of the map around it, and some numbers.

The pictures are centred on the mean of the cluster's cells. The fine one has ``SIDE`` x ``SIDE`` cells, the coarse one
``SIDE`` x ``SIDE`` blocks of ``BLOCK`` x ``BLOCK`` cells. On maps of several levels they show the cluster's level and
``BESIDE`` levels below and above it, each with layers of its own. Off the map counts as occupied.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters, mean_place, place_of

#: Cells, or blocks, along a side of a picture; odd.
SIDE = 25
#: Cells along a side of a block; odd.
BLOCK = 3
#: Levels below and above the cluster's that are shown.
BESIDE = 2
#: Layers of a level of the fine picture: free, occupied, this cluster, unknown, near it through the unknown (255 to 0).
FINE_LAYERS = 5
#: Layers of a level of the coarse picture: numbers of free and of occupied cells of a block.
COARSE_LAYERS = 2
#: Steps through the unknown up to which cells count as near, and over which the nearness falls to 1 / e.
NEAR, FADE = 16, 6.0


class Kind(NamedTuple):
    """What the pictures show: plain maps, or maps of several levels."""

    levels: int
    """L, levels of the pictures, from the lowest to the highest."""
    numbers: int
    """N, the number of numbers beside them."""


PLAIN, LEVELS = Kind(1, 2), Kind(2 * BESIDE + 1, 3)


class Pictures(NamedTuple):
    """Inputs of the network for K clusters, on pictures of L levels with N numbers beside them."""

    fine: NDArray[np.uint8]
    """(K, L FINE_LAYERS, SIDE, SIDE): 0 or 1, the last layer of a level 0 to 255."""
    coarse: NDArray[np.uint8]
    """(K, L COARSE_LAYERS, SIDE, SIDE): 0 to 9."""
    numbers: NDArray[np.float32]
    """(K, N): log(1 + cells of the cluster) / 3, lidar range / 10, and over levels the lidar's elevation / 90."""


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
def _draw_blocks(sums: np.ndarray, first: int, last: int, top: int, left: int, out: np.ndarray) -> None:
    """Count the free and the occupied cells of each block; the level has the rows from ``first`` up to ``last``."""
    rows, cols = np.empty(SIDE + 1, np.int64), np.empty(SIDE + 1, np.int64)
    for place in range(SIDE + 1):
        rows[place] = min(max(top + place * BLOCK, first), last)
        cols[place] = min(max(left + place * BLOCK, 0), sums.shape[1] - 1)
    for r in range(SIDE):
        above, below = sums[rows[r]], sums[rows[r + 1]]
        for c in range(SIDE):
            known = below[cols[c + 1]] - above[cols[c + 1]] - below[cols[c]] + above[cols[c]]
            inside = (rows[r + 1] - rows[r]) * (cols[c + 1] - cols[c])
            out[0, r, c] = known & (_ONE_OCCUPIED - 1)
            out[1, r, c] = (known >> _OCCUPIED_BIT) + BLOCK * BLOCK - inside


@kernel(entry=False)
def _draw_cells(belief: np.ndarray, first: int, last: int, top: int, left: int, out: np.ndarray) -> None:
    """Draw which cells are free, occupied or off the map, and unknown; the level has the rows ``first`` to ``last``."""
    begin, end = min(max(-left, 0), SIDE), min(max(belief.shape[1] - left, 0), SIDE)
    out[1] = 1
    for row in range(max(first - top, 0), min(last - top, SIDE)):
        for col in range(begin, end):
            value = belief[row + top, col + left]
            out[0, row, col] = value == FREE
            out[1, row, col] = value == OCCUPIED
            out[3, row, col] = value == UNKNOWN


#: Cells along a side of a picture with a border, and of one level of it.
_PITCH = SIDE + 2
_LEVEL = _PITCH * _PITCH


@kernel(entry=False)
def _draw_near(picture: np.ndarray, nearness: np.ndarray) -> None:
    """Draw how near unknown cells of a fine picture are to the cluster through them; ``nearness`` by steps."""
    levels = picture.shape[0] // FINE_LAYERS
    left = np.zeros((levels + 2) * _LEVEL, np.uint8)
    queue = np.empty(levels * SIDE * SIDE, np.int32)
    head, tail = 0, 0
    for level in range(levels):
        cells, unknown = picture[level * FINE_LAYERS + 2], picture[level * FINE_LAYERS + 3]
        for row in range(SIDE):
            for col in range(SIDE):
                place = (level + 1) * _LEVEL + (row + 1) * _PITCH + col + 1
                left[place] = unknown[row, col]
                if cells[row, col]:
                    queue[tail] = place
                    tail += 1
    for steps in range(1, NEAR + 1):
        last = tail
        for k in range(head, last):
            at = queue[k]
            for beside in (at + _PITCH, at - 1, at - _PITCH, at + 1, at + _LEVEL, at - _LEVEL):
                if left[beside]:
                    left[beside] = 0
                    level, place = beside // _LEVEL - 1, beside % _LEVEL
                    near = picture[level * FINE_LAYERS + 4]
                    near[place // _PITCH - 1, place % _PITCH - 1] = nearness[steps]
                    queue[tail] = beside
                    tail += 1
        head = last


@kernel()
def _pictures(
    belief: np.ndarray, cells: np.ndarray, ends: np.ndarray, rise: int, fine: np.ndarray, coarse: np.ndarray
) -> None:
    rows, width = belief.shape
    shown, number = fine.shape[1] // FINE_LAYERS, (rows + 1) // rise if rise > 0 else 1
    height, middle = rise - 1 if rise > 0 else rows, SIDE // 2 * BLOCK + BLOCK // 2
    sums, nearness = _sums(belief), np.zeros(NEAR + 1, np.uint8)
    for steps in range(1, NEAR + 1):
        nearness[steps] = np.uint8(255.0 * np.exp(-(steps - 1) / FADE))
    for k in range(ends.shape[0] - 1):
        own = cells[ends[k] : ends[k + 1]]
        mean_level, mean_row, mean_col = mean_place(own, width, rise)
        level, row, col = int(np.round(mean_level)), int(np.round(mean_row)), int(np.round(mean_col))
        lowest, top, left = level - shown // 2, row - SIDE // 2, col - SIDE // 2
        for place in range(shown):
            at = lowest + place
            first = at * rise if 0 <= at < number else 0
            last = first + height if 0 <= at < number else 0
            layers = fine[k, place * FINE_LAYERS : (place + 1) * FINE_LAYERS]
            _draw_cells(belief, first, last, first + top, left, layers)
            blocks = coarse[k, place * COARSE_LAYERS : (place + 1) * COARSE_LAYERS]
            _draw_blocks(sums, first, last, first + row - middle, col - middle, blocks)
        for cell in own:
            at, r, c = place_of(cell, width, rise)
            place, r, c = at - lowest, r - top, c - left
            if 0 <= place < shown and 0 <= r < SIDE and 0 <= c < SIDE:
                fine[k, place * FINE_LAYERS + 2, r, c] = 1
        _draw_near(fine[k], nearness)


def pictures(
    belief: Belief, clusters: Clusters, lidar_range: float, rise: int = 0, elevation: float = 90.0
) -> Pictures:
    """Return the inputs of the network for each of K clusters of a (H, W) belief.

    With levels, ``rise`` is that of :mod:`indoor_explorers.env.grid.levels`, and ``elevation`` the degrees that the
    lidar looks up and down.
    """
    count, kind = clusters.size, LEVELS if rise > 0 else PLAIN
    fine = np.zeros((count, kind.levels * FINE_LAYERS, SIDE, SIDE), np.uint8)
    coarse = np.zeros((count, kind.levels * COARSE_LAYERS, SIDE, SIDE), np.uint8)
    _pictures(belief, clusters.cells, clusters.ends, rise, fine, coarse)
    numbers = np.empty((count, kind.numbers), np.float32)
    numbers[:, 0] = np.log1p(np.diff(clusters.ends)) / 3.0
    numbers[:, 1] = lidar_range / 10.0
    numbers[:, 2:] = elevation / 90.0
    return Pictures(fine, coarse, numbers)
