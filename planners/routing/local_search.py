"""Local search on visiting orders, for objectives that count when each place is reached.

:mod:`~indoor_explorers.planners.routing.min_latency` and
:mod:`~indoor_explorers.planners.routing.discounted_tours` say which objective is meant for what. Tours of which only
the length counts have a search of their own (:mod:`~indoor_explorers.planners.routing.open_tours`), which adds up
differences instead of whole costs.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.compiled import kernel


class Objective(NamedTuple):
    """The cost of an order whose k-th place, of weight w, is reached at time t_k; the last one at T."""

    latency: float
    """Without a rate, the cost is T + latency * sum(w t)."""
    rate: float
    """With a rate above 0, the cost is -sum(w e^(-rate t)), whatever the latency."""


class SearchSettings(NamedTuple):
    """Which changes of an order are tried, for how long, and what they must save."""

    rounds: int
    """The most rounds."""
    reversals: bool
    """Whether pieces are reversed (2-opt) besides moving single places (Or-opt)."""
    least_saving: float
    """A change must save more than this, so that rounding does not turn an order back and forth,"""
    least_share: float
    """and more than this share of the cost."""


@kernel(entry=False)
def cost_of(
    order: np.ndarray, start: np.ndarray, between: np.ndarray, weights: np.ndarray, objective: Objective
) -> float:
    """Return the cost of visiting the places in ``order``, some of K.

    ``start`` (K,) are the times to the first place, ``between`` (K, K) those between places, ``weights`` (K,) theirs.
    """
    latency, rate = objective
    time, weight = start[order[0]], weights[order[0]]
    total = weight * np.exp(-rate * time) if rate > 0.0 else weight * time
    if rate > 0.0:
        for k in range(1, order.shape[0]):
            time += between[order[k - 1], order[k]]
            total += weights[order[k]] * np.exp(-rate * time)
        return float(-total)
    for k in range(1, order.shape[0]):
        time += between[order[k - 1], order[k]]
        total += weights[order[k]] * time
    return float(time + latency * total)


@kernel(entry=False)
def by_nearest(first: int, between: np.ndarray) -> np.ndarray:
    """Return an order of all places that begins with ``first`` and always goes to the nearest place left."""
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


@kernel(entry=False)
def _reverse(order: np.ndarray, i: int, j: int) -> None:
    """Reverse the places from ``i`` to ``j``, both included."""
    while i < j:
        order[i], order[j] = order[j], order[i]
        i, j = i + 1, j - 1


@kernel(entry=False)
def _move(order: np.ndarray, i: int, j: int) -> None:
    """Take the place at ``i`` out and put it in at ``j``."""
    place, step = order[i], 1 if j > i else -1
    while i != j:
        order[i] = order[i + step]
        i += step
    order[j] = place


@kernel(entry=False)
def improve(
    order: np.ndarray,
    start: np.ndarray,
    between: np.ndarray,
    weights: np.ndarray,
    objective: Objective,
    settings: SearchSettings,
) -> float:
    """Improve an order in place, but for its first place; return its cost. The arrays are those of :func:`cost_of`."""
    count = order.shape[0]
    cost = cost_of(order, start, between, weights, objective)
    for _ in range(settings.rounds):
        before = cost
        for i in range(1, count):
            for j in range(1, count):
                bar = cost - settings.least_saving - settings.least_share * abs(cost)
                if i < j and settings.reversals:
                    _reverse(order, i, j)
                    new = cost_of(order, start, between, weights, objective)
                    if new < bar:
                        cost = new
                        bar = cost - settings.least_saving - settings.least_share * abs(cost)
                    else:
                        _reverse(order, i, j)
                if i != j:
                    _move(order, i, j)
                    new = cost_of(order, start, between, weights, objective)
                    if new < bar:
                        cost = new
                    else:
                        _move(order, j, i)
        if cost == before:
            break
    return cost
