"""Our graphs are those of the published code on the same maps, along flights that the published code has recorded."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.learners.published.ariadne import NEIGHBOURS, AriadneGraph
from indoor_explorers.learners.published.ir2 import Ir2Graph
from indoor_explorers.learners.published.lattice import clear_lines
from indoor_explorers.learners.published.marvel import BINS, HALF_VIEW, MarvelGraph, in_order
from indoor_explorers.learners.published.sighted import Observation
from tests.learners.published.recorded import FROZEN, State, belief_of, cells_of, states_of


def pairs(graph: Any, kind: str, lidar_range: float) -> list[tuple[Observation, State]]:
    """Return what our builder and the published one made of the same flight."""
    found, states = [], states_of(FROZEN / f"{kind}.npz")
    ours = graph(states[0]["belief"].shape, lidar_range)
    for state in states:
        belief = belief_of(state)
        found.append((ours.observe(belief, cell_of(state)), state))
    return found


def cell_of(state: State) -> tuple[int, int]:
    row, col = cells_of(state["cell"])[0].tolist()
    return row, col


def sets(near: np.ndarray) -> list[set[int]]:
    return [set(row[row >= 0].tolist()) for row in near]


def test_ariadne_sees_the_same_graph() -> None:
    """Nodes, their order and all features; edges but for ties at the twentieth neighbour."""
    for ours, theirs in pairs(AriadneGraph, "ariadne", 80.0):
        np.testing.assert_array_equal(ours.cells, cells_of(theirs["cells"]))
        np.testing.assert_allclose(ours.features, theirs["features"], atol=1e-6)
        assert ours.own == theirs["own"]
        for node, (mine, other) in enumerate(zip(sets(ours.near), sets(theirs["near"]), strict=True)):
            away = np.square(ours.cells - ours.cells[node]).sum(axis=1)
            tied = np.sort(away)[:NEIGHBOURS][-1]
            assert (away[list(mine ^ other)] == tied).all()


def test_marvel_sees_the_same_graph() -> None:
    """Nodes in the order of the quadtree, features, edges and directions, but for ties between headings."""
    for ours, theirs in pairs(MarvelGraph, "marvel", 25.0):
        assert ours.directions is not None
        np.testing.assert_array_equal(ours.cells, cells_of(theirs["cells"]))
        np.testing.assert_allclose(ours.features[:, [0, 1, 2, 4]], theirs["features"][:, [0, 1, 2, 4]], atol=1e-6)
        np.testing.assert_allclose(ours.directions.frontiers, theirs["frontiers"], atol=1e-6)
        assert sets(ours.near) == sets(theirs["near"])
        assert ours.options.tolist() == theirs["options"].tolist()
        assert ours.legal.tolist() == (theirs["masked"] == 0).tolist()
        assert ours.features[:, 3].sum() == theirs["features"][:, 3].sum()  # steps of the way, which may be another
        shifted = [np.roll(ours.directions.frontiers, k, axis=1) for k in range(-HALF_VIEW, HALF_VIEW + 1)]
        views = np.sum(shifted, axis=0)
        mine, other = (np.round(f[:, 5] * BINS).astype(int) for f in (ours.features, theirs["features"]))
        rows = np.arange(len(mine))
        assert ((mine < 0) == (other < 0)).all()
        np.testing.assert_allclose(views[rows, mine % BINS], views[rows, other % BINS], atol=1e-5)


def test_ir2_sees_nearly_the_same_graph() -> None:
    """Nodes, occupancy and rendezvous utility; some utilities and visits of nodes that come and go differ."""
    graphs: dict[int, Ir2Graph] = {}
    counts, differences = np.zeros(3, np.int64), np.zeros(4, np.int64)
    for state in states_of(FROZEN / "ir2.npz"):
        belief = belief_of(state)
        graph = graphs.setdefault(int(state["agent"]), Ir2Graph(belief.shape, 80.0))
        graph.routes.add([(row, col) for row, col in cells_of(state["heard"]).tolist()])
        lacking = zip(cells_of(state["mates"]).tolist(), state["lacking"] / belief.size, strict=True)
        ours = graph.observe(belief, cell_of(state), {(row, col): float(share) for (row, col), share in lacking})
        if state["step"] == 0:
            continue  # the published code takes all UAVs for at the start before their first moves
        mine = {tuple(cell): k for k, cell in enumerate(ours.cells.tolist())}
        other = {tuple(cell): k for k, cell in enumerate(cells_of(state["cells"]).tolist())}
        both = sorted(mine.keys() & other.keys())
        counts += len(mine), len(other), len(both)
        a, b = ours.features[[mine[cell] for cell in both]], state["features"][[other[cell] for cell in both]]
        np.testing.assert_allclose(a[:, :2], b[:, :2], atol=1e-6)
        differences += (np.abs(a - b)[:, 2:] > 1e-6).sum(axis=0)
        assert state["step"] < 2 or a[:, 3].max() > 0.1
    assert counts[2] >= 0.97 * counts[:2].max()
    utility, rendezvous, visits, occupied = differences
    assert rendezvous == occupied == 0
    assert max(utility, visits) <= 0.03 * counts[2]


@pytest.mark.parametrize("lidar_range", [4.0, 10.0, 20.0])
def test_a_room_looks_alike_in_coarser_cells(lidar_range: float) -> None:
    """Places agree to a cell, and utilities of nodes near the frontier to a third: counts are scaled to pixels."""
    pixel = 80.0 / lidar_range
    found = []
    for scale in (1.0, pixel):
        belief = np.zeros((int(480 / scale), int(640 / scale)), np.uint8)
        belief[: int(240 / scale), : int(320 / scale)] = FREE
        cell = (int(120 / scale), int(160 / scale))
        found.append(AriadneGraph(belief.shape, 80.0 / scale).observe(belief, cell))
    fine, coarse = found
    assert abs(coarse.features[:, :2].max(axis=0) - fine.features[:, :2].max(axis=0)).max() <= 2 * pixel / 640
    assert coarse.features[:, 2].max() == pytest.approx(fine.features[:, 2].max(), rel=0.34)


def test_a_wall_ends_lines_and_an_unknown_cell_too() -> None:
    belief = np.full((5, 9), FREE, np.uint8)
    ends = np.array([[2, 8]])
    assert clear_lines(belief, np.array([[2, 0]]), ends)[0]
    for kind in (OCCUPIED, UNKNOWN):
        shut = belief.copy()
        shut[2, 4] = kind
        assert not clear_lines(shut, np.array([[2, 0]]), ends)[0]
        assert clear_lines(shut, np.array([[2, 0]]), np.array([[2, 4]]))[0]  # the last cell does not count


def test_a_quadtree_lists_leaf_by_leaf() -> None:
    places = [(1, 1), (-1, 1), (2, -1), (-3, -3), (-2, 2), (5, 5)]
    assert in_order(places).tolist() == [1, 4, 0, 5, 3, 2]
    assert in_order(places[:4]).tolist() == [0, 1, 2, 3]
    assert len(in_order([(400, 0), (401, 0), (402, 0), (403, 0), (404, 0)])) == 5
