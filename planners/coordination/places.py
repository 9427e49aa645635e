"""Where clusters are: their means, how far they are, and which of them a goal belongs to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Cell, Distances, Mask
from indoor_explorers.planners.clusters import Clusters, nearest_cells


def sizes(clusters: Clusters) -> NDArray[np.int64]:
    """Return how many frontier cells each of K clusters has, (K,)."""
    return np.diff(clusters.ends)


def means(clusters: Clusters, width: int) -> NDArray[np.float64]:
    """Return the mean row and column of each of K clusters, (K, 2), on a map of ``width`` columns."""
    sums = [np.add.reduceat(part, clusters.ends[:-1]) for part in np.divmod(clusters.cells, width)]
    return np.stack(sums, axis=1) / sizes(clusters)[:, None]


def steps_to(clusters: Clusters, field: Distances) -> Distances:
    """Return the distance of each of K clusters' nearest cell on a (H, W) field, (K,)."""
    return nearest_cells(field, clusters)[1]


def near_goal(clusters: Clusters, goal: Cell, radius: float, width: int) -> Mask:
    """Return which of K clusters have a cell within ``radius`` cells of a goal, (K,) bool."""
    rows, cols = np.divmod(clusters.cells, width)
    near = (rows - goal[0]) ** 2 + (cols - goal[1]) ** 2 <= radius * radius
    return np.logical_or.reduceat(near, clusters.ends[:-1])
