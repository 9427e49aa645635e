from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.search.frontiers import frontier_mask
from indoor_explorers.planners.toolbox.frontiers.clusters import (
    SPREAD,
    Clusters,
    cluster_viewpoints,
    first_of_each,
    frontier_clusters,
    middles,
    nearest_cells,
)
from indoor_explorers.planners.toolbox.navigation.paths import Paths


def parts(clusters: Clusters) -> list[np.ndarray]:
    return np.split(clusters.cells, clusters.ends[1:-1])


def test_unsplit_clusters_agree_with_scipy_labels(belief: Belief) -> None:
    clusters = frontier_clusters(belief, 1e6)
    labels, count = ndimage.label(frontier_mask(belief), structure=np.ones((3, 3)))
    assert clusters.size == count
    for k in range(count):
        cells = parts(clusters)[k]
        assert set(cells.tolist()) == set(np.flatnonzero(labels.ravel() == k + 1).tolist())


@pytest.mark.parametrize("lidar_range", [1.0, 3.0, 6.0])
def test_clusters_are_small_and_hold_every_frontier_cell_once(belief: Belief, lidar_range: float) -> None:
    clusters = frontier_clusters(belief, lidar_range)
    assert sorted(clusters.cells.tolist()) == np.flatnonzero(frontier_mask(belief)).tolist()
    for k in range(clusters.size):
        cells = parts(clusters)[k]
        points = np.stack(np.divmod(cells, belief.shape[1]), axis=1)
        assert len(points) > 0
        assert np.hypot(*(points - points.mean(axis=0)).T).max() <= SPREAD * lidar_range + 1e-6


def test_a_straight_frontier_is_halved() -> None:
    belief = np.ones((3, 8), np.uint8)
    belief[0] = 0
    clusters = frontier_clusters(belief, 4.0)
    assert [len(part) for part in parts(clusters)] == [4, 4]


def test_nearest_cells(belief: Belief, start: Cell) -> None:
    field = Paths((belief.shape[0], belief.shape[1])).field(belief, start)
    clusters = frontier_clusters(belief, 3.0)
    cells, steps = nearest_cells(field, clusters)
    for k in range(clusters.size):
        of_cluster = field.ravel()[parts(clusters)[k]]
        assert steps[k] == min(of_cluster.min(), UNREACHABLE)
        assert field.ravel()[cells[k]] == steps[k]


def test_a_known_map_has_no_clusters() -> None:
    clusters = frontier_clusters(np.ones((4, 4), np.uint8), 3.0)
    assert clusters.size == 0
    assert nearest_cells(np.zeros((4, 4), np.int32), clusters)[0].shape == (0,)


def test_the_middle_is_the_cell_nearest_to_the_mean(belief: Belief) -> None:
    clusters = frontier_clusters(belief, 6.0)
    for k, cell in enumerate(middles(clusters, belief.shape[1]).tolist()):
        cells = parts(clusters)[k]
        points = np.stack(np.divmod(cells, belief.shape[1]), axis=1)
        away = np.hypot(*(points - points.mean(axis=0)).T)
        assert away[cells.tolist().index(cell)] == pytest.approx(away.min())


def test_cluster_viewpoints_are_the_nearest_cell_and_some_others() -> None:
    clusters = Clusters(np.array([4, 5, 6, 7, 8, 9, 20], np.int32), np.array([0, 6, 7]))
    cells, owner = cluster_viewpoints(clusters, np.array([4, 20], np.int32), 3.0)
    assert cells.tolist() == [4, 5, 8, 20]
    assert owner.tolist() == [0, 0, 0, 1]


def test_the_first_of_equals_is_taken() -> None:
    owner, scores = np.array([0, 0, 2, 2, 2]), np.array([1.0, 3.0, 5.0, 5.0, 4.0])
    assert first_of_each(owner, scores).tolist() == [1, 2]
    assert first_of_each(owner[:0], scores[:0]).tolist() == []
