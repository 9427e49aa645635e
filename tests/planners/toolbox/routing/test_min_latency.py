from __future__ import annotations

from itertools import pairwise, permutations

import numpy as np
import pytest

from indoor_explorers.planners.toolbox.routing.min_latency import best_orders


def plain_cost(order: tuple[int, ...], start: np.ndarray, between: np.ndarray, shares: np.ndarray, latency: float):
    time = start[order[0]]
    waiting = shares[order[0]] * time
    for before, after in pairwise(order):
        time += between[before, after]
        waiting += shares[after] * time
    return time + latency * waiting


@pytest.mark.parametrize("latency", [0.0, 1.0, 16.0])
def test_orders_are_nearly_the_cheapest(latency: float) -> None:
    rng = np.random.default_rng(3)
    excess = []
    for _ in range(30):
        count = int(rng.integers(1, 7))
        points = rng.random((count + 1, 2))
        away = np.hypot(*(points[:, None] - points).transpose(2, 0, 1))
        shares = rng.random(count)
        problem = (away[0, 1:].copy(), away[1:, 1:].copy(), shares / shares.sum(), latency)
        found = best_orders(*problem)[0]
        for first in range(count):
            best = min(plain_cost(order, *problem) for order in permutations(range(count)) if order[0] == first)
            assert found[first] >= best - 1e-9
            excess.append(found[first] / best - 1)
    assert np.mean(excess) < 0.01


def test_small_things_on_the_way_wait_when_latency_counts() -> None:
    start, between = np.array([3.0, 10.0]), np.array([[0.0, 13.0], [13.0, 0.0]])
    shares = np.array([0.1, 0.9])
    assert np.argmin(best_orders(start, between, shares, 0.0)[0]) == 0
    assert np.argmin(best_orders(start, between, shares, 16.0)[0]) == 1
