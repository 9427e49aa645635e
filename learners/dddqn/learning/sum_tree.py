"""Sampling in proportion to priorities with a sum tree (Schaul et al. 2016, section 3.3, arXiv:1511.05952).

The tree is a perfect binary tree in one array: node ``k`` is the parent of ``2 k`` and ``2 k + 1`` and holds their
sum; the leaves are the priorities. A write recomputes each sum from both children, so rounding errors do not
accumulate and the leaves alone determine the tree.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel


@kernel()
def _write(tree: np.ndarray, places: np.ndarray, values: np.ndarray) -> None:
    leaves = tree.shape[0] // 2
    for i in range(places.shape[0]):
        node = leaves + places[i]
        tree[node] = values[i]
        while node > 1:
            node //= 2
            tree[node] = tree[2 * node] + tree[2 * node + 1]


@kernel()
def _find(tree: np.ndarray, points: np.ndarray, places: np.ndarray) -> None:
    """Write the place of each of the ``points`` between 0 and the total; a leaf of 0 is never found."""
    leaves = tree.shape[0] // 2
    for i in range(points.shape[0]):
        node, left = 1, points[i]
        while node < leaves:
            node *= 2
            if left >= tree[node] and tree[node + 1] > 0.0:
                left -= tree[node]
                node += 1
        places[i] = node - leaves


class SumTree:
    """Hold a priority for each of ``size`` places, 0 at first."""

    def __init__(self, size: int) -> None:
        self.size = size
        self._tree = np.zeros(2 << (size - 1).bit_length())

    @property
    def total(self) -> float:
        """The sum of all priorities."""
        return float(self._tree[1])

    @property
    def values(self) -> NDArray[np.float64]:
        """(size,) the priorities; a view that callers must not change."""
        leaves = len(self._tree) // 2
        return self._tree[leaves : leaves + self.size]

    def write(self, places: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        """Set the priorities ``values`` (K,) of ``places`` (K,); if a place occurs twice, its last value counts."""
        _write(self._tree, places, values)

    def draw(self, count: int, rng: np.random.Generator) -> NDArray[np.int64]:
        """Draw places (count,) by stratified sampling: one from each of ``count`` equal parts of the total."""
        points = (np.arange(count) + rng.random(count)) * (self.total / count)
        places = np.empty(count, np.int64)
        _find(self._tree, points, places)
        return places
