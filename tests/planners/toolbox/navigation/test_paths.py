from __future__ import annotations

from itertools import pairwise

import networkx as nx
import numpy as np
import pytest
from scipy.sparse import lil_array
from scipy.sparse.csgraph import shortest_path

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.search.frontiers import frontier_cells, frontier_mask, on_frontier
from indoor_explorers.planners.toolbox.navigation.paths import Paths, count_known
from indoor_explorers.planners.toolbox.navigation.straight_paths import straight_path
from tests.planners.flights import graph_of


def lengths(belief: Belief, start: Cell) -> dict[Cell, int]:
    return dict(nx.single_source_shortest_path_length(graph_of(belief == FREE), start))


def assert_is_path(belief: Belief, path: list[Cell]) -> None:
    for (row, col), (r, c) in pairwise(path):
        assert abs(row - r) + abs(col - c) == 1
        assert belief[r, c] == FREE


def test_field_agrees_with_networkx(belief: Belief, start: Cell) -> None:
    field = Paths((belief.shape[0], belief.shape[1])).field(belief, start)
    expected = np.full(belief.shape, UNREACHABLE)
    for cell, steps in lengths(belief, start).items():
        expected[cell] = steps
    assert (field == expected).all()


def test_all_pairs_agree_with_scipy(belief: Belief) -> None:
    rng = np.random.default_rng(0)
    free = np.flatnonzero(belief == FREE)
    numbers = {int(cell): k for k, cell in enumerate(free)}
    width = belief.shape[1]
    graph = lil_array((len(free), len(free)), dtype=np.int8)
    for (row, col), (r, c) in graph_of(belief == FREE).edges:
        graph[numbers[row * width + col], numbers[r * width + c]] = 1
    expected = np.minimum(shortest_path(graph.tocsr(), directed=False, unweighted=True), UNREACHABLE)
    paths = Paths((belief.shape[0], belief.shape[1]))
    for count in (0, 1, 2, 12, len(free)):
        places = rng.integers(0, len(free), count)  # some of them twice
        assert (paths.matrix(belief, free[places].astype(np.int32)) == expected[np.ix_(places, places)]).all()


def test_no_path_leads_to_or_from_what_is_not_free() -> None:
    belief = np.array([[1, 2, 1, 0, 1]], np.uint8)
    steps = Paths((1, 5)).matrix(belief, np.arange(5, dtype=np.int32))
    assert (steps == np.where(np.eye(5), 0, UNREACHABLE)).all()


def test_paths_are_shortest(belief: Belief, start: Cell) -> None:
    paths = Paths((belief.shape[0], belief.shape[1]))
    steps = lengths(belief, start)
    for row, col in np.argwhere(belief == FREE).tolist():
        path = paths.to(belief, start, (row, col))
        if (row, col) not in steps:
            assert path is None
            continue
        assert path is not None
        assert path[0] == start
        assert path[-1] == (row, col)
        assert len(path) == steps[row, col] + 1
        assert_is_path(belief, path)


def test_barred_cells_are_not_entered(belief: Belief, start: Cell) -> None:
    paths = Paths((belief.shape[0], belief.shape[1]))
    graph = graph_of(belief == FREE)
    for barred in list(graph.neighbors(start)):
        without = graph.copy()
        without.remove_node(barred)
        steps = nx.single_source_shortest_path_length(without, start)
        for cell in graph.nodes:
            path = paths.to(belief, start, cell, [barred])
            assert (path is None) == (cell not in steps)
            assert path is None or len(path) == steps[cell] + 1


def test_nearest_frontier_is_nearest(belief: Belief, start: Cell) -> None:
    rng = np.random.default_rng(0)
    steps = lengths(belief, start)
    frontier = [(r, c) for r, c in np.argwhere(frontier_mask(belief)).tolist() if (r, c) in steps]
    path = Paths((belief.shape[0], belief.shape[1])).to_frontier(belief, start, rng)
    assert (path is None) == (not frontier)
    if path is not None:
        assert path[-1] in frontier
        assert len(path) - 1 == min(steps[cell] for cell in frontier)


def test_ties_between_frontiers_are_drawn() -> None:
    belief = np.ones((1, 9), np.uint8)
    belief[0, [0, 8]] = 0
    paths = Paths((1, 9))
    ends = {paths.to_frontier(belief, (0, 4), np.random.default_rng(seed))[-1] for seed in range(20)}  # type: ignore[index]
    assert ends == {(0, 1), (0, 7)}


def test_avoided_frontiers_are_left_alone() -> None:
    belief = np.ones((1, 12), np.uint8)
    belief[0, [0, 11]] = 0
    rng = np.random.default_rng(0)
    paths = Paths((1, 12))
    assert paths.to_frontier(belief, (0, 3), rng, [(0, 1)])[-1] == (0, 10)  # type: ignore[index]
    assert paths.to_frontier(belief, (0, 3), rng, [(0, 2), (0, 9)]) is None


@pytest.mark.parametrize("reach", [1, 2, 5, 1000])
def test_retreats_are_reachable_and_within_reach(belief: Belief, start: Cell, reach: int) -> None:
    paths = Paths((belief.shape[0], belief.shape[1]))
    steps = lengths(belief, start)
    for seed in range(10):
        path = paths.to_anywhere(belief, start, reach, np.random.default_rng(seed))
        assert (path is None) == (len(steps) == 1)
        if path is not None:
            assert 0 < len(path) - 1 == steps[path[-1]] <= reach


def test_frontier_cells_agree_with_the_mask(belief: Belief) -> None:
    cells = np.arange(belief.size, dtype=np.int32)
    assert (frontier_cells(belief, cells) == frontier_mask(belief).ravel()).all()
    assert [on_frontier(belief, cell) for cell in range(belief.size)] == frontier_mask(belief).ravel().tolist()


def test_known_cells_are_counted(belief: Belief) -> None:
    assert count_known(belief) == np.count_nonzero(belief)


def test_straight_paths_are_shortest_paths(belief: Belief, start: Cell) -> None:
    field = distance_field(belief, start)
    for goal in map(tuple, np.argwhere(belief == FREE)[::3].tolist()):
        path = straight_path(belief, start, goal)
        if field[goal] == UNREACHABLE:
            assert path == []
            continue
        assert (path[0], path[-1], len(path)) == (start, goal, field[goal] + 1)
        for before, after in pairwise(path):
            assert abs(before[0] - after[0]) + abs(before[1] - after[1]) == 1
            assert belief[after] == FREE


def test_in_the_open_the_longer_axis_is_shortened_first() -> None:
    path = straight_path(np.ones((9, 9), np.uint8), (0, 0), (3, 6))
    assert path[:4] == [(0, 0), (0, 1), (0, 2), (0, 3)]
    assert {abs((3 - row) - (6 - col)) for row, col in path[3:]} == {0, 1}
