"""Graphs of rooms and doors: exact on floors drawn by hand, whole on generated ones."""

import networkx as nx
import numpy as np
import pytest

from indoor_explorers.env.maps.room_graph import (
    CORRIDOR,
    DOOR,
    ROOM,
    doors_across,
    local_widths,
    loops,
    nodes_of,
    passage_of,
    room_graph,
)
from indoor_explorers.env.maps.sources import FloorsMaps


def floor(text):
    return np.array([[char == "." for char in line] for line in text.split()])


TWO_ROOMS = """
###############
#......#......#
#......#......#
#......#......#
#.............#
#......#......#
#......#......#
###############
"""
TWO_DOORS = """
###############
#......#......#
#.............#
#......#......#
#......#......#
#.............#
#......#......#
###############
"""
NARROW_CORRIDOR = """
#################
#......##....####
#......##....####
#......##....####
#......##....####
####.######..####
#...............#
#...............#
#################
"""


def of_parts(graph, name):
    return [graph.nodes[node][name] for node in nodes_of(graph, ROOM, CORRIDOR)]


def of_doors(graph, name="width"):
    return [graph.nodes[node][name] for node in nodes_of(graph, DOOR)]


def test_rooms_are_cut_apart_at_doors():
    graph = room_graph(floor(TWO_ROOMS))
    assert of_parts(graph, "cells") == [36, 36]
    assert of_parts(graph, "width") == [6, 6]
    assert of_parts(graph, "kind") == [ROOM, ROOM]
    assert (of_doors(graph), of_doors(graph, "place")) == ([1], [(4, 7)])
    assert sorted(graph.edges) == [(1, 3), (2, 3)]
    assert (loops(graph), doors_across(graph)) == (0, 1)


def test_a_second_door_makes_a_loop():
    graph = room_graph(floor(TWO_DOORS))
    assert of_doors(graph) == [1, 1]
    assert (loops(graph), doors_across(graph)) == (1, 1)
    assert [graph.degree[node] for node in nodes_of(graph, ROOM)] == [2, 2]


def test_a_narrow_corridor_is_a_part_and_its_doors_have_their_width():
    graph = room_graph(floor(NARROW_CORRIDOR))
    assert sorted(of_parts(graph, "cells")) == [16, 24, 30 + 3]
    assert of_parts(graph, "kind") == [ROOM, ROOM, CORRIDOR]
    assert sorted(of_doors(graph)) == [1, 2]
    assert (loops(graph), doors_across(graph)) == (0, 2)
    (corridor,) = nodes_of(graph, CORRIDOR)
    assert graph.degree[corridor] == 2


def test_an_alcove_belongs_to_its_room_however_long_it_is():
    free = np.zeros((20, 30), np.bool_)
    free[5:15, 2:28] = True
    free[3:5, 4:8] = True
    free[15:17, 3:27] = True
    graph = room_graph(free)
    assert of_parts(graph, "cells") == [free.sum()]
    assert len(graph) == 1
    assert (loops(graph), doors_across(graph)) == (0, 0)


def test_a_pillar_makes_no_loop():
    free = np.pad(np.ones((10, 12), np.bool_), 1)
    free[5, 6] = False
    graph = room_graph(free)
    assert (of_parts(graph, "cells"), loops(graph)) == ([119], 0)


def test_two_corridors_that_meet_a_room_at_one_corner_have_a_door_each():
    """Their cells beside the room touch diagonally, and are no single place of meeting."""
    free = np.zeros((24, 24), np.bool_)
    free[2:12, 2:12] = True
    free[12:23, 10:12] = True
    free[10:12, 12:23] = True
    graph = room_graph(free, 3)
    assert nx.is_connected(graph)
    assert of_parts(graph, "kind") == [ROOM, CORRIDOR, CORRIDOR]
    assert (len(of_doors(graph)), loops(graph)) == (2, 0)


@pytest.mark.parametrize("seed", range(8))
def test_graphs_of_connected_floors_are_connected_and_hold_every_cell(seed):
    free = np.pad(FloorsMaps(height=96, width=120, area=(300.0, 1000.0)).draw(np.random.default_rng(seed)), 1)
    graph = room_graph(free)
    assert nx.is_connected(graph)
    assert nx.is_bipartite(graph)
    assert sum(of_parts(graph, "cells")) <= free.sum()
    assert all(free[place] for _, place in graph.nodes(data="place"))
    assert all(graph.degree[door] >= 2 for door in nodes_of(graph, DOOR))
    assert loops(graph) == len(nx.cycle_basis(graph))


def test_the_width_at_a_cell_is_that_of_the_largest_square_over_it():
    free = np.random.default_rng(3).random((14, 17)) < 0.85
    free[4:10, 3:12] = True
    expected = np.zeros(free.shape, int)
    for side in range(1, 15):
        for row in range(15 - side):
            for col in range(18 - side):
                if free[row : row + side, col : col + side].all():
                    expected[row : row + side, col : col + side] = side
    assert (local_widths(free) == expected).all()
    assert local_widths(free).max() >= 6


def test_the_width_of_a_passage_is_in_metres_where_a_map_has_a_scale():
    assert [passage_of(each) for each in (0.5, 0.25, 5.0, None)] == [3, 6, 1, 3]
