from __future__ import annotations

import networkx as nx
import numpy as np
import pytest

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, UNKNOWN, UNREACHABLE
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.sensing.lidar import lidar_model, view_gain
from indoor_explorers.planners.toolbox.information.candidates import (
    UnknownWeight,
    candidate_views,
    cell_weight,
    depths,
    distances_between,
    frontier_candidates,
    local_candidates,
)
from tests.planners.flights import graph_of

PLAIN = UnknownWeight(0.0, 1e9)


def test_depths_are_steps_through_the_unknown(belief: Belief) -> None:
    out = np.empty(belief.shape, np.int32)
    depths(belief, np.empty(belief.size, np.int32), out)
    known = [tuple(cell) for cell in np.argwhere(belief == FREE).tolist()]
    edges = [(a, b) for a, b in nx.grid_2d_graph(*belief.shape).edges if UNKNOWN in (belief[a], belief[b])]
    passable = nx.Graph(edge for edge in edges if all(belief[cell] in (FREE, UNKNOWN) for cell in edge))
    unknown = graph_of(belief == UNKNOWN)
    fronts = {b for a in known if a in passable for b in passable[a]}
    expected = nx.multi_source_dijkstra_path_length(unknown, fronts) if fronts else {}
    for cell in np.ndindex(*belief.shape):
        assert out[cell] == (expected[cell] + 1 if cell in expected else UNREACHABLE)


def test_plain_views_are_view_gains_and_their_overlaps(belief: Belief) -> None:
    cells = np.flatnonzero(belief == FREE).astype(np.int32)[:20]
    gains, shared = candidate_views(belief, cells, PLAIN, lidar_model(4.0))
    assert gains == pytest.approx([view_gain(belief, divmod(cell, belief.shape[1]), 4.0) for cell in cells.tolist()])
    both = shared * gains[:, None]
    assert both == pytest.approx(both.T)
    assert (both <= np.minimum(gains[:, None], gains) + 1e-9).all()
    assert np.diag(shared) == pytest.approx(np.where(gains > 0, 1.0, 0.0))


def test_overlap_of_two_views_on_a_line() -> None:
    belief = np.array([[1, 0, 0, 0, 0, 0, 1]], np.uint8)
    gains, shared = candidate_views(belief, np.array([0, 6], np.int32), PLAIN, lidar_model(4.0))
    assert gains.tolist() == pytest.approx([4, 4])
    assert shared[0, 1] == shared[1, 0] == pytest.approx(3 / 4)


def test_worth_is_more_in_pockets_and_less_in_the_deep() -> None:
    belief = np.full((9, 9), UNKNOWN, np.uint8)
    belief[0] = FREE
    depth = np.empty(belief.shape, np.int32)
    depths(belief, np.empty(belief.size, np.int32), depth)
    assert cell_weight(belief, depth, 4 * 9 + 4, UnknownWeight(8.0, 2.0)) == pytest.approx(np.exp(-2.0))
    assert cell_weight(belief, depth, 1 * 9 + 4, UnknownWeight(8.0, 2.0)) == pytest.approx(
        (1 + 8 * 10 / 24) * np.exp(-0.5)
    )


def test_hops_are_shortest_up_to_the_limit(belief: Belief) -> None:
    start = tuple(np.argwhere(belief == FREE)[0].tolist())
    field = distance_field(belief, start)
    cells = np.flatnonzero((belief == FREE) & (field < UNREACHABLE)).astype(np.int32)[::3]
    steps = field.ravel()[cells].astype(np.float64)[None]
    lengths = dict(nx.all_pairs_shortest_path_length(graph_of(belief == FREE)))
    between = distances_between(belief, cells, steps, 5)
    for a, one in enumerate(cells.tolist()):
        for b, other in enumerate(cells.tolist()):
            exact = lengths[divmod(one, belief.shape[1])][divmod(other, belief.shape[1])]
            assert between[a, b] == (exact if exact <= 5 else steps[0, a] + steps[0, b])


def test_candidates_can_be_reached_and_show_something(belief: Belief) -> None:
    start = tuple(np.argwhere(belief == FREE)[0].tolist())
    field = distance_field(belief, start)
    ahead = frontier_candidates(belief, field[None], 3.0, 5)
    around = local_candidates(belief, field[None], 3.0, 4, 0.3, 6)
    assert len(ahead) <= 5
    assert len(around) <= 6
    for cell in [*ahead.tolist(), *around.tolist()]:
        assert field.flat[cell] < UNREACHABLE
        assert view_gain(belief, divmod(cell, belief.shape[1]), 3.0) > 0
    assert (field.ravel()[around] <= 4).all()
