"""The order of MARVEL's nodes: its network convolves over them, so that its outputs depend on their order.

The published code keeps nodes in a quadtree (Finkel and Bentley 1974) over 1,000 m around the start, at most four to a
leaf, and lists them leaf by leaf: upper left, upper right, lower left, lower right; in a leaf, in their order of
insertion. Here the order follows from the nodes' places on the lattice.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

#: Half the side of the tree in distances of nodes; nodes of a leaf.
HALF, CAPACITY = 125.0, 4


def in_order(places: Sequence[tuple[int, int]]) -> NDArray[np.int64]:
    """Return the order (N,) in which nodes are listed, of (x, y) places on the lattice in the order of insertion."""
    half, furthest = HALF, max((max(map(abs, place)) for place in places), default=0)
    while half < furthest:
        half *= 2
    points = np.array(places, np.float64).reshape(-1, 2)
    return _listed(points, np.arange(len(points)), np.zeros(2), half)


def _listed(
    points: NDArray[np.float64], nodes: NDArray[np.int64], centre: NDArray[np.float64], half: float
) -> NDArray[np.int64]:
    """Return the nodes of a square, leaf by leaf."""
    if len(nodes) <= CAPACITY:
        return nodes
    right, below = (points[nodes] >= centre)[:, 0], (points[nodes] < centre)[:, 1]
    quarters = [(-1, 1), (1, 1), (-1, -1), (1, -1)]
    parts = [nodes[(right == (x > 0)) & (below == (y < 0))] for x, y in quarters]
    middles = [centre + np.array(quarter) * (half / 2) for quarter in quarters]
    return np.concatenate(
        [_listed(points, part, middle, half / 2) for part, middle in zip(parts, middles, strict=True)]
    )
