"""Minimum-latency orders, whose cost also contains the length of the tour.

The cost of an order is the time at which its last place is reached, plus a multiple of the weighted mean waiting time
of the places. Without the second part this is the open travelling salesman problem, without the first the minimum
latency problem (A. Blum et al., STOC 1994, doi:10.1145/195058.195125).
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.planners.toolbox.routing.local_search import Objective, SearchSettings, by_nearest, improve

#: Largest number of rounds of improvement.
ROUNDS = 8
#: Saving that a change must exceed, in units of the distances.
LEAST_SAVING = 1e-9


@kernel(entry=False)
def improved_cost(
    order: np.ndarray, start: np.ndarray, between: np.ndarray, shares: np.ndarray, latency: float
) -> float:
    """Improve an ``order`` (L,) of some of K places in place, keeping its first place; return its cost.

    ``start`` (K,) are the times to a first place, ``between`` (K, K) those between places, and ``shares`` (K,) the
    weights of waiting times.
    """
    return float(
        improve(order, start, between, shares, Objective(latency, 0.0), SearchSettings(ROUNDS, True, LEAST_SAVING, 0.0))
    )


@kernel()
def best_orders(
    start: np.ndarray, between: np.ndarray, shares: np.ndarray, latency: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the costs of the best orders found that begin at each of K places, and the best of these orders.

    ``start`` (K,) are the distances from the UAV, ``between`` (K, K) those between the places. The weights ``shares``
    (K,) add up to one; ``latency`` is the weight of the mean waiting time relative to the length. The costs are (K,);
    the order is returned as each place's position in it, (K,).
    """
    count = start.shape[0]
    costs, positions, best = np.empty(count), np.zeros(count, np.int64), np.inf
    for first in range(count):
        order = by_nearest(first, between)
        costs[first] = improved_cost(order, start, between, shares, latency)
        if costs[first] < best:
            best = costs[first]
            for k in range(count):
                positions[order[k]] = k
    return costs, positions
