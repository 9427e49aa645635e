"""True pockets, the unknown free cells behind each frontier cluster: the labels that the pocket network learns from.

The free cells that a UAV does not know yet, and can reach, are divided among the frontier clusters that it can reach: a
cell belongs to the cluster from which it is reached first, through cells that are not known or not reached yet.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Distances
from indoor_explorers.env.grid.cells import FREE, UNKNOWN, UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.grid.levels import beside, degree
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters


class Pockets(NamedTuple):
    """The pockets behind K frontier clusters; zero behind one that cannot be reached."""

    sizes: NDArray[np.float64]
    """(K,) number of unknown free cells."""
    depths: NDArray[np.float64]
    """(K,) steps from the cluster to the farthest of them."""


@kernel()
def _pockets(
    belief: np.ndarray, truth: np.ndarray, field: np.ndarray, cells: np.ndarray, ends: np.ndarray, rise: int
) -> tuple[np.ndarray, np.ndarray]:
    height, width = belief.shape
    count = ends.shape[0] - 1
    sizes, depths = np.zeros(count), np.zeros(count)
    owner, steps = np.full(belief.shape, -1, np.int32), np.zeros(belief.shape, np.int32)
    queue, head, tail = np.empty(belief.size + cells.shape[0], np.int32), 0, 0
    for k in range(count):
        for place in range(ends[k], ends[k + 1]):
            row, col = divmod(cells[place], width)
            if field[row, col] < UNREACHABLE:
                owner[row, col] = k
                queue[tail] = cells[place]
                tail += 1
    while head < tail:
        row, col = divmod(queue[head], width)
        head += 1
        k = owner[row, col]
        if belief[row, col] == UNKNOWN:
            sizes[k] += 1.0
            depths[k] = steps[row, col]
        for move in range(degree(rise)):
            r, c = beside(row, col, move, rise)
            if not (0 <= r < height and 0 <= c < width) or owner[r, c] >= 0 or truth[r, c] != FREE:
                continue
            if belief[r, c] == UNKNOWN or field[r, c] >= UNREACHABLE:
                owner[r, c], steps[r, c] = k, steps[row, col] + 1
                queue[tail] = r * width + c
                tail += 1
    return sizes, depths


def true_pockets(belief: Belief, truth: Belief, field: Distances, clusters: Clusters, rise: int = 0) -> Pockets:
    """Return the pockets behind K clusters.

    ``belief`` and ``truth`` are (H, W); ``field`` (H, W) holds the UAV's steps through known free cells. With levels,
    these are planes, and ``rise`` is that of :mod:`indoor_explorers.env.grid.levels`.
    """
    return Pockets(*_pockets(belief, truth, field, clusters.cells, clusters.ends, rise))
