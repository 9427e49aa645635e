"""Completions of a map: possible contents of the unknown cells, drawn from the estimates behind frontier clusters.

The estimates (:mod:`indoor_explorers.planners.toolbox.pockets`) are probabilities of more than t unknown free cells
behind a cluster, for several t. A completion draws one quantile, takes the size at this quantile behind each cluster,
and lets pockets of these sizes grow from the clusters through unknown cells, breadth-first, all at once. Unknown cells
that no pocket reaches are occupied. So the unknown is open in one completion and cluttered in another; with sizes drawn
one by one, pockets of different depths would border each other everywhere, with walls that hardly any map has.
The sizes follow the learned prior; the shapes do not: rooms and corridors are round pockets here.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, MOVES, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters
from indoor_explorers.planners.toolbox.pockets.estimates import BEYOND
from indoor_explorers.planners.toolbox.pockets.network import THRESHOLDS

#: log(1 + size) of the largest pocket that is drawn and of the thresholds of the tail probabilities, falling.
_LOGS = np.log1p([THRESHOLDS[-1] + BEYOND, *THRESHOLDS[::-1]])


class Completions(NamedTuple):
    """P maps that agree with a (H, W) belief."""

    maps: NDArray[np.uint8]
    """(P, H, W) without unknown cells."""
    owners: NDArray[np.int16]
    """(P, H*W) the cluster from which the pocket of a cell has grown, -1 for cells of none."""


def pocket_sizes(tails: NDArray[np.float64], quantiles: NDArray[np.float64], scale: float = 1.0) -> NDArray[np.int64]:
    """Return sizes of pockets behind K clusters in P completions, (P, K), at P quantiles in [0, 1] from large to small.

    ``tails`` (K, T) are the probabilities of more than ``THRESHOLDS`` cells, falling along each line; between
    thresholds a distribution is linear in log(1 + size). All sizes are multiplied by ``scale``.
    """
    sizes = np.empty((len(quantiles), len(tails)), np.int64)
    for k, tail in enumerate(tails):
        logs = np.interp(quantiles, np.concatenate([[0.0], tail[::-1]]), _LOGS)
        sizes[:, k] = np.ceil(scale * np.expm1(logs) - 1e-9)
    return sizes


def strata(count: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return quantiles in random order, one in each of ``count`` equal parts of [0, 1)."""
    return rng.permutation((np.arange(count) + rng.random(count)) / count)


@kernel()
def _grow(
    belief: np.ndarray, cells: np.ndarray, ends: np.ndarray, sizes: np.ndarray, maps: np.ndarray, owners: np.ndarray
) -> None:
    """Fill ``maps`` (P, H, W) and ``owners`` (P, H*W), -1 at first, by pockets of (P, K) ``sizes``."""
    height, width = belief.shape
    queue, source = np.empty(belief.size + cells.shape[0], np.int32), np.empty(belief.size + cells.shape[0], np.int32)
    left = np.empty(ends.shape[0] - 1, np.int64)
    for p in range(sizes.shape[0]):
        tail, head = 0, 0
        for k in range(left.shape[0]):
            left[k] = sizes[p, k]
            for place in range(ends[k], ends[k + 1]):
                queue[tail], source[tail] = cells[place], k
                tail += 1
        while head < tail:
            row, col = divmod(queue[head], width)
            k = source[head]
            head += 1
            for move in range(4 if left[k] > 0 else 0):
                r, c = row + MOVES[move, 0], col + MOVES[move, 1]
                inside = 0 <= r < height and 0 <= c < width and left[k] > 0
                if inside and belief[r, c] == UNKNOWN and owners[p, r * width + c] < 0:
                    owners[p, r * width + c] = k
                    left[k] -= 1
                    queue[tail], source[tail] = r * width + c, k
                    tail += 1
        for row in range(height):
            for col in range(width):
                maps[p, row, col] = belief[row, col]
                if belief[row, col] == UNKNOWN:
                    maps[p, row, col] = FREE if owners[p, row * width + col] >= 0 else OCCUPIED


def completions(belief: Belief, clusters: Clusters, sizes: NDArray[np.int64]) -> Completions:
    """Return the completions of a (H, W) belief with pockets of (P, K) ``sizes`` behind its K clusters."""
    maps = np.empty((len(sizes), *belief.shape), np.uint8)
    owners = np.full((len(sizes), belief.size), -1, np.int16)
    _grow(belief, clusters.cells, clusters.ends, sizes, maps, owners)
    return Completions(maps, owners)
