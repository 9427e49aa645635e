"""Prices of cells, against the linear program solved by another method."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from indoor_explorers.env.search.cell_prices import cell_prices
from indoor_explorers.env.search.walk_graph import WalkGraph
from tests.env.search.small_maps import connected_map
from tests.env.search.test_walk_graph import graph_of


def least_flow(graph: WalkGraph, team: int, missable: int) -> float:
    """Return the cheapest flow that shows all unseen cells but ``missable``, by HiGHS."""
    count, steps, states = len(graph.unseen), len(graph.target), len(graph.cells)
    seen, flow = np.zeros((count + 1, steps + count + states)), np.zeros((states, steps + count + states))
    seen[graph.shown, np.repeat(np.arange(steps), np.diff(graph.offsets))] = -1.0
    seen[np.arange(count), steps + np.arange(count)] = -1.0
    seen[count, steps : steps + count] = 1.0
    flow[graph.sources, np.arange(steps)] += 1.0
    flow[graph.target, np.arange(steps)] -= 1.0
    flow[np.arange(states), steps + count + np.arange(states)] = 1.0
    found = linprog(
        np.repeat([1.0, 0.0], [steps, count + states]),
        A_ub=seen,
        b_ub=np.append(-np.ones(count), missable),
        A_eq=flow,
        b_eq=(np.arange(states) < team).astype(np.float64),
    )
    assert found.fun is not None
    return float(found.fun)


@pytest.mark.parametrize("memory", [1, 2])
@pytest.mark.parametrize(("team", "missable"), [(1, 0), (1, 4), (2, 2)])
def test_prices_come_close_to_the_best_there_are(memory, team, missable):
    truth, places = connected_map(3 * team + missable, (12, 12), 0.25)
    graph, _ = graph_of(truth, places[:team], memory)
    prices = cell_prices(graph, team, missable, 3000)
    assert prices.price.min() >= 0.0
    worth = np.sort(prices.price)[: len(prices.price) - missable].sum() + prices.potential[:team].sum()
    worth -= team * prices.potential.max()
    best = least_flow(graph, team, missable)
    assert worth == pytest.approx(best, rel=0.02)
    earned = np.add.reduceat(np.append(prices.price[graph.shown], 0.0), graph.offsets[:-1])
    earned[np.diff(graph.offsets) == 0] = 0.0
    assert (earned - prices.potential[graph.target] + prices.potential[graph.sources]).max() < 1.1


def test_the_same_prices_come_out_every_time():
    truth, places = connected_map(0, (9, 9), 0.2)
    graph, _ = graph_of(truth, places[:1], 2)
    first, again = (cell_prices(graph, 1, 1, 200) for _ in range(2))
    np.testing.assert_array_equal(first.price, again.price)
