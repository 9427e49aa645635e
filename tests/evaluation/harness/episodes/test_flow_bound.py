"""The flow bound holds for every team, and is close to the fewest steps there are."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env import PRESETS, World
from indoor_explorers.env.search.cell_prices import cell_prices
from indoor_explorers.env.search.visibility import visibility_table
from indoor_explorers.env.sensing.lidar import lidar_model
from indoor_explorers.evaluation.harness.episodes import flow_bound as bounds
from indoor_explorers.evaluation.harness.episodes.flow_bound import flow_bound
from indoor_explorers.evaluation.harness.episodes.lower_bounds import least_steps
from tests.env.search.small_maps import connected_map
from tests.env.search.test_cell_prices import least_flow
from tests.env.search.test_walk_graph import graph_of
from tests.evaluation.harness.episodes.test_lower_bounds import SHARES, fewest_steps


def bound_of(truth, starts, reach, share):
    table = visibility_table(truth, starts, lidar_model(reach), count_all_cells=False)
    return flow_bound(table, len(starts), len(table.cells) - math.ceil(share * len(table.cells) - 1e-9))


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), rows=st.integers(2, 5), columns=st.integers(3, 5), reach=st.sampled_from([1.0, 2.0]))
def test_no_walk_is_shorter(seed, rows, columns, reach):
    truth, cells = connected_map(seed, (rows, columns), 0.3)
    best = fewest_steps(truth, cells[:1], reach, SHARES)
    for share in SHARES:
        assert bound_of(truth, cells[:1], reach, share) <= best[share]


@pytest.mark.parametrize("seed", range(6))
def test_no_walks_of_two_are_shorter(seed):
    truth, cells = connected_map(seed, (4, 4), 0.3)
    best = fewest_steps(truth, cells[:2], 1.0, SHARES)
    for share in SHARES:
        assert bound_of(truth, cells[:2], 1.0, share) <= best[share]


@pytest.mark.parametrize("rounds", [1, 20, 600])
def test_prices_are_made_feasible_whatever_they_were(rounds):
    truth, places = connected_map(7, (12, 14), 0.25)
    graph, _ = graph_of(truth, places[:1], 2)
    prices = cell_prices(graph, 1, 2, rounds)
    bounds._make_feasible(graph, prices)
    earned = np.add.reduceat(np.append(prices.price[graph.shown], 0.0), graph.offsets[:-1])
    earned[np.diff(graph.offsets) == 0] = 0.0
    allowed = 1.0 + prices.potential[graph.target] - prices.potential[graph.sources]
    assert (earned - allowed).max() < 1e-9
    assert bounds._worth(prices, 1, 2) <= least_flow(graph, 1, 2) + 1e-6


@pytest.mark.parametrize(("scenario", "seed", "expected"), [("thesis-open", 0, 42), ("thesis-obstacles", 1, 49)])
def test_bounds_in_rooms_of_the_thesis(scenario, seed, expected):
    world = World(PRESETS[scenario].for_evaluation())
    world.begin(0, seed)
    assert least_steps(world, 0, 0.99) == expected


def test_maps_too_large_for_it_have_none(monkeypatch):
    truth, cells = connected_map(0, (9, 9), 0.2)
    assert bound_of(truth, cells[:1], 2.0, 1.0) > 0
    monkeypatch.setattr(bounds, "WORK", 1000)
    assert bound_of(truth, cells[:1], 2.0, 1.0) == 0
