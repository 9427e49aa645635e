from __future__ import annotations

from itertools import pairwise, permutations

import numpy as np
import pytest

from indoor_explorers.planners.sampling.cover_tours import improved_tour, value_of_tour


def plain_value(costs: np.ndarray, worths: np.ndarray, order: tuple[int, ...], rate: float) -> float:
    arrivals = np.cumsum([costs[a, b] for a, b in pairwise(order)])
    return float((worths[list(order[1:])] * np.exp(-rate * arrivals)).sum()) if rate else -float(arrivals[-1])


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("rate", [0.0, 0.1])
def test_improved_tours_are_near_the_best(seed: int, rate: float) -> None:
    rng = np.random.default_rng(seed)
    points, worths = rng.random((6, 2)) * 20, np.append(0.0, rng.random(5))
    costs = np.hypot(*(points[:, None] - points[None]).T)
    begun = np.arange(6)
    order, found = improved_tour(costs, worths, begun, rate)
    assert sorted(order.tolist()) == begun.tolist()
    assert order[0] == 0
    assert found == pytest.approx(plain_value(costs, worths, tuple(order.tolist()), rate))
    assert found == pytest.approx(value_of_tour(costs, worths, order, rate))
    every = [plain_value(costs, worths, (0, *rest), rate) for rest in permutations(range(1, 6))]
    assert max(every) - 0.25 * abs(max(every)) <= found <= max(every) + 1e-9
    assert found >= plain_value(costs, worths, tuple(begun.tolist()), rate) - 1e-9
