from __future__ import annotations

import numpy as np
import pytest

from indoor_explorers.env.grid.cells import OCCUPIED, UNKNOWN
from indoor_explorers.env.search.bitsets import around, hash_keys, packed, unpacked
from indoor_explorers.planners.horizon import beam
from indoor_explorers.planners.horizon.beam import BeamConfig, SearchGraph, shortest_tour
from indoor_explorers.planners.toolbox.information.optimistic_views import OptimisticViews


def graph_of(belief: np.ndarray, lidar: float, weights: np.ndarray) -> SearchGraph:
    optimistic = OptimisticViews(belief.shape, lidar)
    optimistic.update(belief)
    keys = hash_keys(2 * belief.size)
    views, neighbours, within = optimistic.views, optimistic.neighbours, optimistic.views_within
    return SearchGraph(views, neighbours, within, around(belief.shape), keys, weights)


def config(width: int, depth: int = 60, completion: float = 0.0) -> BeamConfig:
    return BeamConfig(8.0, 0.02, completion, width, depth)


def shortest(start: int, unseen: set[int], graph: SearchGraph, size: int) -> int:
    """Breadth-first search over (cell, unseen set)."""
    views = [frozenset(np.flatnonzero(unpacked(bits, size)).tolist()) for bits in graph.views]
    layer, met, steps = {(start, frozenset(unseen))}, {(start, frozenset(unseen))}, 0
    while all(rest for _, rest in layer):
        moves = {(n, rest - views[n]) for cell, rest in layer for n in graph.neighbours[cell].tolist() if n >= 0}
        layer = moves - met
        met |= layer
        steps += 1
    return steps


@pytest.mark.parametrize("seed", range(6))
def test_a_wide_beam_finds_the_shortest_tour(seed: int) -> None:
    rng = np.random.default_rng(seed)
    belief = np.where(rng.random((5, 6)) < 0.15, OCCUPIED, UNKNOWN).astype(np.uint8)
    belief[0, 0] = belief[0, 1] = 1
    graph = graph_of(belief, 1.0, np.ones(30))
    optimistic = OptimisticViews(belief.shape, 1.0)
    optimistic.update(belief)
    unseen = packed(belief == UNKNOWN) & optimistic.attainable(0)
    members = set(np.flatnonzero(unpacked(unseen, 30)).tolist())
    tour, finishes = shortest_tour(0, unseen, graph, 0.0, config(4000))
    assert finishes
    assert len(tour) == shortest(0, members, graph, 30)
    for before, after in zip([0, *tour.tolist()], tour.tolist(), strict=False):
        assert after in graph.neighbours[before]
        members -= set(np.flatnonzero(unpacked(graph.views[after], 30)).tolist())
    assert not members


def worth(unseen: np.ndarray, weights: np.ndarray, isolation: float) -> float:
    """What is left to see by the formula in the module's docstring."""
    wide = np.pad(unseen.astype(int), 1)
    height, width = unseen.shape
    near = sum(wide[r : r + height, c : c + width] for r in range(3) for c in range(3)) - unseen
    return float((unseen * weights.reshape(unseen.shape) * (1 + isolation * (1 - near / 8))).sum())


@pytest.mark.parametrize("seed", range(4))
def test_states_are_ranked_by_the_formula(seed: int) -> None:
    rng = np.random.default_rng(seed)
    belief = np.where(rng.random((8, 9)) < 0.1, OCCUPIED, rng.integers(0, 2, (8, 9))).astype(np.uint8)
    belief[4, 4] = 1
    weights = rng.random(72)
    graph = graph_of(belief, 2.0, weights)
    states, children = beam._new_states(1, 2), beam._new_states(4, 2)
    beam._root(40, packed(belief == UNKNOWN), graph, 8.0, states)
    found, _ = beam._expand(states, 1, graph, config(1, completion=0.5), -1.0, np.zeros(64, np.uint64), children)
    assert found == (graph.neighbours[40] >= 0).sum()
    for k in range(found):
        seen = unpacked(graph.views[children.cell[k]], 72).reshape(8, 9)
        unseen = (belief == UNKNOWN) & ~seen
        assert children.worth[k] == pytest.approx(worth(unseen, weights, 8.0))
        assert children.left[k] == pytest.approx(weights[unseen.ravel()].sum())
        assert np.array_equal(unpacked(children.unseen[k], 72), unseen.ravel())
        within = graph.views_within[:, children.cell[k]]
        sooner = [not (packed(unseen) & seen).any() for seen in within]
        all_seen = [not (packed(unseen) & ~seen).any() for seen in within]
        steps = 0.02 * sum(sooner) + 0.5 * (len(all_seen) - sum(all_seen))
        assert children.rank[k] == pytest.approx(children.worth[k] + steps)


def test_a_tour_may_stop_before_everything_is_seen() -> None:
    belief = np.zeros((1, 20), np.uint8)
    belief[0, :2] = 1
    graph = graph_of(belief, 1.0, np.ones(20))
    unseen = packed(belief == UNKNOWN)
    assert shortest_tour(0, unseen, graph, 0.0, config(10))[0].tolist() == list(range(1, 19))
    assert shortest_tour(0, unseen, graph, 5.0, config(10))[0].tolist() == list(range(1, 14))
    tour, finishes = shortest_tour(0, unseen, graph, 0.0, config(10, depth=4))
    assert tour.tolist() == [1, 2, 3, 4]
    assert not finishes
