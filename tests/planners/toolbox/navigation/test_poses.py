from __future__ import annotations

import networkx as nx
import numpy as np
import pytest

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE, MOVES, UNKNOWN, UNREACHABLE
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.planners.toolbox.information.pose_views import camera, heading_gains
from indoor_explorers.planners.toolbox.navigation.poses import ANY, pose_steps, steps_between, steps_left
from indoor_explorers.planners.toolbox.navigation.view_paths import WayParameters, view_path

CAMERA = camera(4.0, 90.0)


def graph(belief: Belief) -> nx.DiGraph:
    """The graph of poses: moves to free cells, and turns."""
    free = {(row, col) for row, col in np.argwhere(belief == FREE).tolist()}
    edges = nx.DiGraph()
    for cell in free:
        for facing in range(4):
            edges.add_edge((cell, facing), (cell, (facing + 1) % 4))
            for move in range(4):
                to = (cell[0] + int(MOVES[move, 0]), cell[1] + int(MOVES[move, 1]))
                if to in free:
                    edges.add_edge((cell, facing), (to, move))
    return edges


def poses_of(belief: Belief, count: int) -> list[tuple[Cell, int]]:
    rng = np.random.default_rng(5)
    cells = [(row, col) for row, col in np.argwhere(belief == FREE).tolist()]
    return [(cells[int(rng.integers(len(cells)))], int(rng.integers(4))) for _ in range(count)]


def flat(belief: Belief, poses: list[tuple[Cell, int]]) -> tuple[np.ndarray, np.ndarray]:
    cells = np.array([row * belief.shape[1] + col for (row, col), _ in poses], np.int32)
    return cells, np.array([heading for _, heading in poses])


def test_steps_between_poses_are_shortest_paths(belief: Belief) -> None:
    edges, poses = graph(belief), poses_of(belief, 10)
    cells, headings = flat(belief, poses)
    fields = np.stack([distance_field(belief, cell) for cell, _ in poses])
    steps = pose_steps(fields, cells, headings, cells, headings)
    between = steps_between(belief, cells, headings, steps.astype(np.float64), belief.size)
    for i, a in enumerate(poses):
        lengths = nx.single_source_shortest_path_length(edges, a)
        expected = [lengths.get(b, UNREACHABLE) for b in poses]
        assert steps[i].tolist() == expected
        assert [min(each, UNREACHABLE) for each in between[i].tolist()] == expected


def test_any_heading_takes_the_steps_to_the_cell(belief: Belief) -> None:
    cells, headings = flat(belief, poses_of(belief, 10))
    field = distance_field(belief, divmod(int(cells[0]), belief.shape[1]))
    steps = pose_steps(field[None], cells[:1], headings[:1], cells, np.full(10, ANY))
    assert steps[0].tolist() == field.ravel()[cells].tolist()


def test_steps_left_are_those_of_a_uav_that_moves_first(belief: Belief) -> None:
    edges = graph(belief)
    for goal, heading in poses_of(belief, 4):
        left = steps_left(belief, goal[0] * belief.shape[1] + goal[1], heading)
        lengths = nx.single_target_shortest_path_length(edges, (goal, heading))
        for cell in np.argwhere(belief == FREE).tolist():
            after = [
                1 + lengths[to]
                for to in edges[(tuple(cell), 0)]
                if to[0] != tuple(cell) and to in dict(lengths)
            ]
            assert left[tuple(cell)] == min(after, default=UNREACHABLE)


def shown(belief: Belief, way: list[tuple[Cell, int]]) -> int:
    """The unknown cells in view of any pose of a way but the first."""
    cells, headings = flat(belief, way)
    seen = 0
    for cell in np.flatnonzero(belief.ravel() == UNKNOWN):
        value = np.zeros(belief.size)
        value[cell] = 1.0
        gains = heading_gains(belief, cells[1:], value, CAMERA)
        seen += bool((gains[np.arange(len(way) - 1), headings[1:]] > 0).any())
    return seen


def headed(path: list[Cell], facing: int) -> list[tuple[Cell, int]]:
    """The poses of a path, in which a cell that follows itself is a turn."""
    way = [(path[0], facing)]
    for before, after in zip(path, path[1:], strict=False):
        step = (after[0] - before[0], after[1] - before[1])
        facing = (facing + 1) % 4 if step == (0, 0) else [tuple(move) for move in MOVES[:4].tolist()].index(step)
        way.append((after, facing))
    return way


@pytest.mark.parametrize("slack", [0, 3])
def test_ways_are_short_and_end_in_the_pose(belief: Belief, slack: int) -> None:
    edges, value = graph(belief), (belief.ravel() == UNKNOWN).astype(np.float64)
    poses = poses_of(belief, 12)
    for start, goal in zip(poses[::2], poses[1::2], strict=True):
        path = view_path(belief, value, CAMERA, start, goal, WayParameters(1.0, slack, 8, 16))
        if not nx.has_path(edges, start, goal):
            assert path == []
            continue
        way = headed(path, start[1])
        assert way[-1] == goal
        assert all(edges.has_edge(a, b) for a, b in zip(way, way[1:], strict=False))
        assert len(way) - 1 <= nx.shortest_path_length(edges, start, goal) + slack


def test_a_wide_search_finds_the_shortest_way_that_shows_most() -> None:
    belief = np.full((7, 9), UNKNOWN, np.uint8)
    belief[2:5, 2:7] = FREE
    value, edges = (belief.ravel() == UNKNOWN).astype(np.float64), graph(belief)
    start, goal = ((2, 2), 3), ((4, 5), 0)
    path = view_path(belief, value, CAMERA, start, goal, WayParameters(1.0, 0, 8, 10_000))
    most = max(shown(belief, way) for way in nx.all_shortest_paths(edges, start, goal))
    assert shown(belief, headed(path, start[1])) == most


def test_a_turn_pays_where_it_shows_more_than_its_price() -> None:
    belief = np.full((9, 9), FREE, np.uint8)
    belief[6:, :4] = UNKNOWN
    value = (belief.ravel() == UNKNOWN).astype(np.float64)
    start, goal = ((4, 1), 3), ((4, 7), 3)
    dear = view_path(belief, value, CAMERA, start, goal, WayParameters(100.0, 3, 8, 64))
    cheap = view_path(belief, value, CAMERA, start, goal, WayParameters(1.0, 3, 8, 64))
    assert len(dear) == 7
    assert len(cheap) > 7 and shown(belief, headed(cheap, 3)) > shown(belief, headed(dear, 3))
