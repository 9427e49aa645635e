"""Local search on visiting orders, for objectives that depend on the times of arrival.

:mod:`~indoor_explorers.planners.toolbox.routing.min_latency` and
:mod:`~indoor_explorers.planners.sampling.cover_tours` describe the objectives. Tours whose cost is their length
have a search of their own (:mod:`~indoor_explorers.planners.toolbox.routing.open_tours`), which adds up differences
instead of whole costs.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.compiled import kernel


class Objective(NamedTuple):
    """The cost of an order whose places have weights w and times of arrival t, the last one T."""

    latency: float
    """If the rate is 0, the cost is T + latency * sum(w t)."""
    rate: float
    """If the rate is above 0, the cost is -sum(w e^(-rate t)), independent of the latency."""


class SearchSettings(NamedTuple):
    """The changes of an order that are tried, and the improvement that they must have."""

    rounds: int
    """Largest number of rounds."""
    reversals: bool
    """Whether pieces are reversed (2-opt) in addition to moving single places (Or-opt)."""
    least_saving: float
    """Saving that a change must exceed, so that rounding cannot make the search cycle."""
    least_share: float
    """Saving that a change must exceed, as a share of the cost."""


@kernel(entry=False)
def cost_of(
    order: np.ndarray, start: np.ndarray, between: np.ndarray, weights: np.ndarray, objective: Objective
) -> float:
    """Return the cost of visiting the places in ``order``, some of K.

    ``start`` (K,) are the times to a first place, ``between`` (K, K) those between places, ``weights`` (K,) the places'
    weights.
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
    """Return the nearest-neighbour order of K places that begins with ``first``, (K,); ``between`` is (K, K)."""
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
    """Move the place at ``i`` to ``j``."""
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
    """Improve an ``order`` (L,) of some of K places in place, keeping its first place; return its cost.

    The other arrays are as in :func:`cost_of`.
    """
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
