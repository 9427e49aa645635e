"""The order in which to visit places: a travelling repairman who also wants to be done early.

The cost of an order is when its last place is reached plus a multiple of the mean waiting time of the places, each
weighted by what it is worth. Without the second part this is the open travelling salesman problem, without the first
the minimum latency problem (A. Blum et al., STOC 1994, doi:10.1145/195058.195125). Orders are improved by 2-opt and
by moving single places.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.compiled import kernel

#: Rounds of improvement after which an order is good enough.
ROUNDS = 8
#: An order counts as better when it saves more than this, so that rounding does not turn it back and forth.
LEAST_SAVING = 1e-9


@kernel()
def _cost(order: np.ndarray, start: np.ndarray, between: np.ndarray, shares: np.ndarray, latency: float) -> float:
    time = start[order[0]]
    waiting = shares[order[0]] * time
    for k in range(1, order.shape[0]):
        time += between[order[k - 1], order[k]]
        waiting += shares[order[k]] * time
    return float(time + latency * waiting)


@kernel()
def by_nearest(first: int, between: np.ndarray) -> np.ndarray:
    """Return an order from ``first`` on that always goes to the nearest place left."""
    count = between.shape[0]
    order = np.arange(count)
    order[0], order[first] = first, 0
    for k in range(1, count - 1):
        best = k
        for j in range(k + 1, count):
            if between[order[k - 1], order[j]] < between[order[k - 1], order[best]]:
                best = j
        order[k], order[best] = order[best], order[k]
    return order


@kernel()
def _reverse(order: np.ndarray, i: int, j: int) -> None:
    """Turn the places from ``i`` to ``j``, both included, round."""
    while i < j:
        order[i], order[j] = order[j], order[i]
        i, j = i + 1, j - 1


@kernel()
def _move(order: np.ndarray, i: int, j: int) -> None:
    """Take the place at ``i`` out and put it in at ``j``."""
    place, step = order[i], 1 if j > i else -1
    while i != j:
        order[i] = order[i + step]
        i += step
    order[j] = place


@kernel()
def improved(order: np.ndarray, start: np.ndarray, between: np.ndarray, shares: np.ndarray, latency: float) -> float:
    """Improve an order in place, its first place aside; return its cost."""
    count = order.shape[0]
    cost = _cost(order, start, between, shares, latency)
    for _ in range(ROUNDS):
        before = cost
        for i in range(1, count):
            for j in range(1, count):
                if i < j:
                    _reverse(order, i, j)
                    new = _cost(order, start, between, shares, latency)
                    if new < cost - LEAST_SAVING:
                        cost = new
                    else:
                        _reverse(order, i, j)
                if i != j:
                    _move(order, i, j)
                    new = _cost(order, start, between, shares, latency)
                    if new < cost - LEAST_SAVING:
                        cost = new
                    else:
                        _move(order, j, i)
        if cost == before:
            break
    return cost


@kernel()
def costs_of_first(start: np.ndarray, between: np.ndarray, shares: np.ndarray, latency: float) -> np.ndarray:
    """Return for each of K places the cost of the best order found that begins there, (K,).

    ``start`` (K,) are the distances from where the UAV is, ``between`` (K, K) those between the places; ``shares``
    (K,) add up to one; ``latency`` is what the mean waiting time counts beside the length.
    """
    count = start.shape[0]
    costs = np.empty(count)
    for first in range(count):
        costs[first] = improved(by_nearest(first, between), start, between, shares, latency)
    return costs
