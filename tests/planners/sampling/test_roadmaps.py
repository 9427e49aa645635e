from __future__ import annotations

import networkx as nx
import numpy as np
import pytest

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.planners.sampling.roadmaps import Roadmap, grow_roadmap
from indoor_explorers.planners.sampling.segments import ALL_KNOWN, trace


def some_belief() -> Belief:
    return np.random.default_rng(1).choice(3, (30, 40), p=[0.1, 0.8, 0.1]).astype(np.uint8)


def some_roadmap() -> Roadmap:
    rng = np.random.default_rng(0)
    free = np.argwhere(some_belief() == 1)
    points = free[rng.integers(len(free), size=150)] + rng.random((150, 2))
    return grow_roadmap(some_belief(), points)


def test_edges_stay_in_known_free_cells() -> None:
    belief, roadmap = some_belief(), some_roadmap()
    assert len(roadmap.edges) > 150
    for first, second in roadmap.edges.tolist():
        assert first < second
        assert trace(belief, *roadmap.points[first], *roadmap.points[second]) == ALL_KNOWN


def test_in_the_open_neighbours_are_joined() -> None:
    points = np.random.default_rng(2).random((40, 2)) * 9
    roadmap = grow_roadmap(np.ones((9, 9), np.uint8), points)
    away = np.hypot(*(points[:, None] - points[None]).T) + np.diag(np.full(40, np.inf))
    joined = {tuple(edge) for edge in roadmap.edges.tolist()}
    assert all((min(k, m), max(k, m)) in joined for k, m in enumerate(away.argmin(axis=0).tolist()))


def test_lengths_agree_with_networkx() -> None:
    roadmap = some_roadmap()
    graph = nx.Graph()
    graph.add_nodes_from(range(len(roadmap.points)))
    for first, second in roadmap.edges.tolist():
        graph.add_edge(first, second, weight=float(np.hypot(*(roadmap.points[first] - roadmap.points[second]))))
    lengths = roadmap.lengths_from(0, 7)
    for row, source in zip(lengths, (0, 7), strict=True):
        expected = nx.single_source_dijkstra_path_length(graph, source)
        assert set(np.flatnonzero(np.isfinite(row)).tolist()) == set(expected)
        assert all(row[k] == pytest.approx(length) for k, length in expected.items())


@pytest.mark.parametrize("count", [0, 1])
def test_few_points(count: int) -> None:
    roadmap = grow_roadmap(np.ones((5, 5), np.uint8), np.full((count, 2), 2.5))
    assert roadmap.edges.shape == (0, 2)
    if count:
        assert roadmap.lengths_from(0).tolist() == [[0.0]]
