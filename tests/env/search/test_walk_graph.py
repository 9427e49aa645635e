"""Walks with a memory, against walks that are listed one by one."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env.search.visibility import TILE, add_visible, visibility_table
from indoor_explorers.env.search.walk_graph import WalkGraph, walk_graph
from indoor_explorers.env.sensing.lidar import lidar_model, scan
from tests.env.search.small_maps import connected_map


def graph_of(truth, starts, memory) -> tuple[WalkGraph, np.ndarray]:
    table = visibility_table(truth, starts, lidar_model(2.0), count_all_cells=False)
    known = np.zeros_like(table.union)
    for start in range(len(starts)):
        add_visible(table, start, known)
    return walk_graph(table, len(starts), memory, known), table.cells


def seen_from(truth, cells, walk):
    return {k for cell in walk for k in np.flatnonzero(scan(truth, divmod(cells[cell], truth.shape[1]), 2.0) == 1)}


def flat(codes, width):
    across = -(-width // TILE)
    tile, bit = np.divmod(codes, 64)
    return (tile // across * TILE + bit // TILE) * width + tile % across * TILE + bit % TILE


@pytest.mark.parametrize("memory", [1, 2, 3])
@pytest.mark.parametrize("team", [1, 2])
def test_steps_lead_on_and_show_what_is_not_remembered(memory, team):
    truth, places = connected_map(5 + team, (6, 10), 0.3)
    graph, cells = graph_of(truth, places[:team], memory)
    first_seen = seen_from(truth, cells, range(team))
    states = [tuple(cell for cell in row if cell >= 0) for row in graph.cells.tolist()]
    unseen = flat(graph.unseen, truth.shape[1])
    assert states[:team] == [(n,) for n in range(team)]
    for state, (begin, end) in enumerate(zip(graph.first, graph.first[1:], strict=False)):
        onwards = graph.cells[graph.target[begin:end], 0]
        assert set(abs(cells[onwards] - cells[states[state][0]])) <= {1, truth.shape[1]}
        for step in range(begin, end):
            onward = states[graph.target[step]]
            assert onward == (onward[0], *states[state])[:memory]
            shown = unseen[graph.shown[graph.offsets[step] : graph.offsets[step + 1]]]
            expected = seen_from(truth, cells, onward[:1]) - seen_from(truth, cells, states[state]) - first_seen
            assert sorted(shown) == sorted(expected)


def test_every_walk_is_in_the_graph():
    truth, places = connected_map(1, (4, 5), 0.3)
    single, _ = graph_of(truth, places[:1], 1)
    longer, _ = graph_of(truth, places[:1], 3)

    def walks(graph):
        found = {(0,): 0}
        for _ in range(4):
            found = {
                (*walk, int(graph.cells[graph.target[step], 0])): graph.target[step]
                for walk, state in found.items()
                for step in range(graph.first[state], graph.first[state + 1])
            }
        return set(found)

    assert walks(longer) == walks(single)
    assert single.sources.tolist() == sorted(single.sources.tolist())
