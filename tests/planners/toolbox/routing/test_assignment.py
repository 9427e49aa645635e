from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.planners.toolbox.routing.assignment import matched


def total(costs: NDArray[np.float64], extra: float, goals: tuple[int, ...]) -> float:
    return float(sum(costs[i, goal] for i, goal in enumerate(goals)) + extra * (len(goals) - len(set(goals))))


@pytest.mark.parametrize(("uavs", "clusters"), [(1, 3), (2, 4), (3, 3), (3, 2), (4, 1), (5, 2)])
def test_the_match_costs_least_among_all_that_share_evenly(uavs: int, clusters: int) -> None:
    for seed in range(10):
        costs, extra = np.random.default_rng(seed).random((uavs, clusters)) * 10, 4.0
        most = -(-uavs // clusters)
        fair = [g for g in product(range(clusters), repeat=uavs) if max(g.count(k) for k in g) <= most]
        assert total(costs, extra, tuple(matched(costs, extra).tolist())) == pytest.approx(
            min(total(costs, extra, goals) for goals in fair)
        )
