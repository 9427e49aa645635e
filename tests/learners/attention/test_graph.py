from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN, UNREACHABLE
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.learners.attention.graph import (
    FEATURES,
    GUIDEPOST,
    TRUE_FEATURES,
    USEFUL,
    UTILITY,
    Graph,
    GraphSettings,
    Surroundings,
    known_graph,
    true_graph,
)
from tests.learners.places.small import world_on_a_floor

SETTINGS = GraphSettings()
#: Two rooms of 6 x 6 cells behind one door in row 3; the right one ends in unknown cells.
TWO_ROOMS = np.full((8, 16), OCCUPIED, np.uint8)
TWO_ROOMS[1:7, 1:7] = TWO_ROOMS[1:7, 8:14] = TWO_ROOMS[3, 7] = FREE
TWO_ROOMS[1:7, 14] = UNKNOWN


def graph_of(belief: np.ndarray, cell: tuple[int, int], reach: float = 10.0, **more) -> Graph:
    visited = np.zeros(belief.shape, np.bool_)
    visited[cell] = True
    return known_graph(belief, cell, distance_field(belief, cell), Surroundings(reach, visited, **more), SETTINGS)


def test_every_part_of_a_block_has_one_node_and_the_first_is_that_of_the_uav() -> None:
    graph, side = graph_of(TWO_ROOMS, (2, 2)), SETTINGS.side(10.0)
    assert side == 4
    assert graph.cells[0] == 2 * 16 + 2
    assert len(set(graph.cells.tolist())) == len(graph.cells)
    blocks = {(cell // 16 // side, cell % 16 // side) for cell in graph.cells[1:].tolist()}
    assert len(blocks) == len(graph.cells) - 1 == 8
    assert len(graph_of(TWO_ROOMS, divmod(int(graph.cells[1]), 16)).cells) == 8
    walled = TWO_ROOMS.copy()
    walled[[1, 2, 3, 4, 6], 5] = OCCUPIED  # cuts the upper block in two, and has a door in the lower one
    assert len(graph_of(walled, (2, 2)).cells) == 10


def test_nodes_are_joined_by_the_shortest_paths_through_free_cells() -> None:
    graph = graph_of(TWO_ROOMS, (2, 2))
    for node, edges in enumerate(graph.neighbours):
        steps = distance_field(TWO_ROOMS, divmod(int(graph.cells[node]), 16)).ravel()[graph.cells]
        there = edges[edges >= 0]
        assert node not in there
        assert len(set(there.tolist())) == len(there) == min(SETTINGS.neighbours, len(graph.cells) - 1)
        assert steps[there].tolist() == sorted(steps)[1 : len(there) + 1]


def test_nothing_behind_a_wall_or_unknown_is_in_the_graph() -> None:
    shut = TWO_ROOMS.copy()
    shut[3, 7] = OCCUPIED
    graph = graph_of(shut, (2, 2))
    assert (graph.cells % 16 < 7).all()
    assert (shut.ravel()[graph.cells] == FREE).all()
    alone = np.full((3, 3), UNKNOWN, np.uint8)
    alone[1, 1] = FREE
    assert graph_of(alone, (1, 1)).neighbours.tolist() == [[-1] * SETTINGS.neighbours]


def test_utility_and_guideposts_lead_to_the_unknown() -> None:
    graph = graph_of(TWO_ROOMS, (2, 2), reach=3.0)
    rows, cols = np.divmod(graph.cells, 16)
    assert (cols[graph.features[:, USEFUL] > 0] > 9).all()
    assert (graph.features[cols <= 8, UTILITY] == 0).all()
    posts = graph.features[:, GUIDEPOST] > 0
    assert posts[(rows == 3) & (cols == 7)].all()
    assert posts[0]
    assert not posts[(rows > 5) & (cols < 6)].any()
    known = TWO_ROOMS.copy()
    known[1:7, 14] = OCCUPIED
    assert not graph_of(known, (2, 2)).features[:, [UTILITY, USEFUL, GUIDEPOST]].any()


def test_a_visited_node_is_not_useful() -> None:
    graph = graph_of(TWO_ROOMS, (3, 13), reach=3.0)
    assert graph.features[0, USEFUL] == 0
    assert graph.features[1:, USEFUL].any()


def test_teammates_and_goals_are_features() -> None:
    alone, near = graph_of(TWO_ROOMS, (2, 2)), graph_of(TWO_ROOMS, (2, 2), mates=((2, 12),), goals=((2, 12),))
    assert not alone.features[:, -3:].any()
    closest = np.hypot(*np.subtract(np.divmod(near.cells, 16), [[2], [12]])).argmin()
    assert near.features[:, -3].argmax() == near.features[:, -2].argmax() == closest
    assert near.features[closest, -1] == 1.0
    assert near.features[0, -1] == 0.0


@pytest.mark.parametrize("seed", [3, 4])
def test_the_true_graph_begins_with_the_known_one(seed: int) -> None:
    world = world_on_a_floor(seed)
    view, truth = world.view(0, 0), np.array(world.state.truth[0])
    steps, around = distance_field(view.belief, view.cell), Surroundings(4.0, view.visited)
    known = known_graph(view.belief, view.cell, steps, around, SETTINGS)
    true = true_graph(view.belief, truth, view.cell, steps, around, SETTINGS)
    count = len(known.cells)
    assert true.cells[:count].tolist() == known.cells.tolist()
    np.testing.assert_array_equal(true.features[:count, :FEATURES], known.features)
    assert true.features.shape == (len(true.cells), TRUE_FEATURES)
    assert true.features[:, -2].tolist() == [0.0] * count + [1.0] * (len(true.cells) - count)
    assert (truth.ravel()[true.cells] == FREE).all()
    assert len(true.cells) > count
    assert (steps.ravel()[known.cells] < UNREACHABLE).all()
