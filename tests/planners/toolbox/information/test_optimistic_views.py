from __future__ import annotations

import networkx as nx
import numpy as np
import pytest

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.search.bitsets import unpacked
from indoor_explorers.env.sensing.lidar import lidar_model, new_scan, visible_cells
from indoor_explorers.planners.toolbox.information.optimistic_views import OptimisticViews
from tests.planners.flights import graph_of


def seen_from(belief: Belief, cell: int, lidar_range: float) -> set[int]:
    lidar = lidar_model(lidar_range)
    work = new_scan(lidar)
    row, col = divmod(cell, belief.shape[1])
    count = visible_cells(belief, row, col, lidar, work)
    return set(work.cells[:count].tolist())


def not_obstacles(belief: Belief) -> nx.Graph:
    graph = graph_of(belief != OCCUPIED)
    return nx.relabel_nodes(graph, {node: node[0] * belief.shape[1] + node[1] for node in graph})


def members(bits: np.ndarray, size: int) -> set[int]:
    return set(np.flatnonzero(unpacked(bits, size)).tolist())


@pytest.mark.parametrize("lidar", [1.0, 3.0])
def test_views_are_those_of_the_lidar_and_of_shortest_paths(belief: Belief, start: Cell, lidar: float) -> None:
    optimistic, graph = OptimisticViews(belief.shape, lidar), not_obstacles(belief)
    optimistic.update(belief)
    cell = start[0] * belief.shape[1] + start[1]
    steps = optimistic.first_steps(cell)
    expected = np.full(belief.size, optimistic.views_within.shape[0])
    for place, distance in nx.single_source_shortest_path_length(graph, cell).items():
        seen = list(seen_from(belief, place, lidar))
        assert members(optimistic.views[place], belief.size) == set(seen)
        expected[seen] = np.minimum(expected[seen], distance)
    assert np.array_equal(steps, np.minimum(expected, optimistic.views_within.shape[0]))
    reach = {n for n in optimistic.neighbours[cell].tolist() if n >= 0}
    assert reach == set(graph.neighbors(cell))


def test_views_kept_up_to_date_are_views_made_anew(belief: Belief) -> None:
    rng, optimistic = np.random.default_rng(3), OptimisticViews(belief.shape, 3.0)
    now = np.zeros_like(belief)
    for _ in range(5):
        shown = rng.random(belief.shape) < 0.3
        now[shown] = belief[shown]
        grown = optimistic.update(now)
        anew = OptimisticViews(belief.shape, 3.0)
        anew.update(now)
        assert np.array_equal(optimistic.views, anew.views)
        assert np.array_equal(optimistic.views_within, anew.views_within)
    assert not optimistic.update(np.where(now == 0, FREE, now))
    assert isinstance(grown, bool)


def test_what_is_walled_in_is_not_attainable() -> None:
    belief = np.zeros((1, 7), np.uint8)
    belief[0, :4] = FREE, FREE, FREE, OCCUPIED
    optimistic = OptimisticViews(belief.shape, 2.0)
    optimistic.update(belief)
    assert members(optimistic.attainable(0), 7) == {0, 1, 2, 3}
    assert members(optimistic.attainable(5), 7) == {3, 4, 5, 6}
