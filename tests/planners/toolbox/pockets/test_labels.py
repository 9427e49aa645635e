from __future__ import annotations

import networkx as nx
import numpy as np
import pytest

from indoor_explorers.env.grid.levels import Levels, plane_of
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters
from indoor_explorers.planners.toolbox.pockets.labels import true_pockets
from tests.planners.flights import graph_of


def known_part(truth: np.ndarray, known: np.ndarray) -> np.ndarray:
    """The belief of a UAV that knows some cells of a map."""
    return np.where(known, truth, 0).astype(np.uint8)


def test_a_room_behind_a_door_is_the_pocket_of_its_door() -> None:
    rows = ["##########", "#...#....#", "#...d....#", "#...#....#", "##########"]
    truth = np.array([[2 if cell == "#" else 1 for cell in row] for row in rows], np.uint8)
    belief = known_part(truth, np.arange(10)[None, :] <= 4)
    clusters = frontier_clusters(belief, 10.0)
    pockets = true_pockets(belief, truth, distance_field(belief, (1, 1)), clusters)
    assert pockets.sizes.tolist() == [12.0]
    assert pockets.depths.tolist() == [5.0]


def test_free_cells_seen_but_not_reached_lead_on() -> None:
    truth = np.full((3, 12), 2, np.uint8)
    truth[1, 1:11] = 1
    belief = known_part(truth, np.isin(np.arange(12), (0, 1, 2, 3, 6, 7))[None, :])
    clusters = frontier_clusters(belief, 10.0)
    pockets = true_pockets(belief, truth, distance_field(belief, (1, 1)), clusters)
    first = int(np.flatnonzero(clusters.cells == 1 * 12 + 3)[0])
    assert pockets.sizes[first] == pockets.sizes.sum() == 5.0  # columns 4, 5, and, behind known 6 and 7, 8 to 10
    assert pockets.depths[first] == 7.0


@pytest.mark.parametrize("seed", range(6))
def test_the_unknown_free_cells_are_parted_among_the_clusters(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = np.where(rng.random((14, 17)) < 0.3, 2, 1).astype(np.uint8)
    truth[5, 5] = 1
    belief = known_part(truth, rng.random(truth.shape) < 0.7)
    belief[5, 5] = 1
    field = distance_field(belief, (5, 5))
    clusters = frontier_clusters(belief, 4.0)
    pockets = true_pockets(belief, truth, field, clusters)
    reachable = nx.node_connected_component(graph_of(truth != 2), (5, 5))
    assert pockets.sizes.sum() == sum(belief[cell] == 0 for cell in reachable)
    steps = field.ravel()[clusters.cells]
    for k in range(clusters.size):
        if (steps[clusters.ends[k] : clusters.ends[k + 1]] > 10**6).all():
            assert pockets.sizes[k] == pockets.depths[k] == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_pockets_reach_over_levels(seed: int) -> None:
    """The unknown free voxels that networkx reaches are parted among the clusters, whatever their level."""
    rng = np.random.default_rng(seed)
    levels = Levels(4, 7, 8)
    volume = np.where(rng.random(tuple(levels)) < 0.35, 2, 1).astype(np.uint8)
    volume[1, 3, 3] = 1
    truth, cell = plane_of(volume), levels.cell((1, 3, 3))
    belief = known_part(truth, (rng.random(truth.shape) < 0.6) | levels.between)
    belief[cell] = 1
    clusters = frontier_clusters(belief, 4.0, levels.rise)
    pockets = true_pockets(belief, truth, distance_field(belief, cell, levels.rise), clusters, levels.rise)
    graph = nx.grid_graph(tuple(levels)[::-1])
    graph.remove_nodes_from([tuple(voxel) for voxel in np.argwhere(volume == 2).tolist()])
    reachable = nx.node_connected_component(graph, (1, 3, 3))
    assert {voxel[0] for voxel in reachable} == {0, 1, 2, 3}
    assert pockets.sizes.sum() == sum(belief[levels.cell(voxel)] == 0 for voxel in reachable)
    flat = true_pockets(belief, truth, distance_field(belief, cell), clusters)
    assert flat.sizes.sum() < pockets.sizes.sum()
