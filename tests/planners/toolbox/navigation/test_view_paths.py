from __future__ import annotations

import itertools

import networkx as nx
import numpy as np
import pytest

from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.env.grid.cells import FREE, MOVES, OCCUPIED, UNKNOWN, UNREACHABLE
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.sensing.lidar import scan
from indoor_explorers.planners.toolbox.information.camera import camera, unknown_weights
from indoor_explorers.planners.toolbox.information.candidates import UnknownWeight
from indoor_explorers.planners.toolbox.navigation.view_paths import WayParameters, view_path

Pose = tuple[Cell, int]


def sector(belief: Belief, cell: Cell, heading: int, degrees: float, reach: float = 4.0) -> Mask:
    """The unknown cells that the world's scan would show if they were free, angle by angle, (H, W) bool."""
    open_map = np.where(belief == OCCUPIED, OCCUPIED, FREE).astype(np.uint8)
    rows, cols = np.indices(belief.shape) - np.reshape(cell, (2, 1, 1))
    faced = np.arctan2(MOVES[heading, 1], MOVES[heading, 0])
    angle = np.abs((np.arctan2(cols, rows) - faced + np.pi) % (2 * np.pi) - np.pi)
    ahead = (angle <= np.radians(degrees / 2) + 1e-6) | (np.maximum(abs(rows), abs(cols)) <= 1)
    return np.asarray(ahead & (scan(open_map, cell, reach) != UNKNOWN) & (belief == UNKNOWN))


def shown(belief: Belief, way: list[Pose], degrees: float) -> int:
    """How many unknown cells the poses of a way but the first show."""
    return int(np.any([sector(belief, cell, heading, degrees) for cell, heading in way[1:]], axis=0).sum())


def headed(path: list[Cell], facing: int) -> list[Pose]:
    """The poses of a path, in which a cell that follows itself is a turn."""
    way = [(path[0], facing)]
    for before, after in itertools.pairwise(path):
        step = (after[0] - before[0], after[1] - before[1])
        facing = (facing + 1) % 4 if step == (0, 0) else [tuple(move) for move in MOVES[:4].tolist()].index(step)
        way.append((after, facing))
    return way


def plain(belief: Belief) -> np.ndarray:
    return (belief.ravel() == UNKNOWN).astype(np.float64)


def free_cells(belief: Belief, count: int) -> list[Cell]:
    cells = [(row, col) for row, col in np.argwhere(belief == FREE).tolist()]
    return [cells[k] for k in np.random.default_rng(5).integers(len(cells), size=count)]


@pytest.mark.parametrize("slack", [0, 3])
def test_ways_lead_to_the_goal_and_are_no_longer_than_allowed(belief: Belief, slack: int) -> None:
    cells = free_cells(belief, 12)
    for start, goal in zip(cells[::2], cells[1::2], strict=True):
        path = view_path(belief, plain(belief), camera(4.0, 90.0), (start, 2), goal, WayParameters(1.0, slack, 8, 16))
        steps = int(distance_field(belief, start)[goal])
        assert (not path) == (steps >= UNREACHABLE)
        if path:
            assert (path[0], path[-1]) == (start, goal)
            assert all(belief[cell] == FREE for cell in path[1:])
            assert len(headed(path, 2)) - 1 <= steps + slack


@pytest.mark.parametrize("degrees", [60.0, 90.0, 120.0, 360.0])
def test_a_wide_search_finds_the_shortest_way_whose_sectors_show_most(degrees: float) -> None:
    belief = np.full((7, 9), UNKNOWN, np.uint8)
    belief[2:5, 2:7], belief[1, 4] = FREE, OCCUPIED
    start, goal = (2, 2), (4, 6)
    free = {(row, col) for row, col in np.argwhere(belief == FREE).tolist()}
    paths = list(nx.all_shortest_paths(nx.grid_2d_graph(*belief.shape).subgraph(free), start, goal))
    most = max(shown(belief, headed(path, 3), degrees) for path in paths)
    ways = WayParameters(1.0, 0, 8, 1000)
    found = view_path(belief, plain(belief), camera(4.0, degrees), (start, 3), goal, ways)
    assert found in paths
    assert shown(belief, headed(found, 3), degrees) == most


def test_a_turn_pays_where_it_shows_more_than_its_price() -> None:
    belief = np.full((9, 9), FREE, np.uint8)
    belief[6:, :4] = UNKNOWN
    ways = [
        view_path(belief, plain(belief), camera(4.0, 90.0), ((4, 1), 3), (4, 7), WayParameters(price, 3, 8, 64))
        for price in (100.0, 1.0)
    ]
    assert len(ways[0]) == 7 < len(ways[1])
    assert shown(belief, headed(ways[0], 3), 90.0) < shown(belief, headed(ways[1], 3), 90.0)


def test_all_around_the_heading_at_the_start_does_not_matter(belief: Belief) -> None:
    start, goal = free_cells(belief, 2)
    ways = [
        view_path(belief, plain(belief), camera(4.0, 360.0), (start, k), goal, WayParameters(1.0, 0, 8, 16))
        for k in range(4)
    ]
    assert all(way == ways[0] for way in ways)


def test_weights_are_those_of_unknown_cells_alone(belief: Belief) -> None:
    value = unknown_weights(belief, UnknownWeight(0.0, 2.0))
    assert ((value > 0.0) <= (belief.ravel() == UNKNOWN)).all()
