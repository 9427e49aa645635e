"""Tours with discounted gains: the value is the sum of the places' gains, each discounted by its time of arrival.

With a discount rate of 0 the value is the negative length of the tour.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.planners.toolbox.routing.local_search import Objective, SearchSettings, cost_of, improve

#: Largest number of rounds of improvement: practically unlimited.
ROUNDS = 2**31
#: Relative improvement that a change must exceed.
LEAST_SHARE = 1e-9


@kernel()
def _value(costs: np.ndarray, gains: np.ndarray, order: np.ndarray, rate: float) -> float:
    return float(-cost_of(order, costs[order[0]], costs, gains, Objective(0.0, rate)))


@kernel()
def _improve(costs: np.ndarray, gains: np.ndarray, order: np.ndarray, rate: float) -> float:
    settings = SearchSettings(ROUNDS, False, 0.0, LEAST_SHARE)
    return float(-improve(order, costs[order[0]], costs, gains, Objective(0.0, rate), settings))


def value_of_tour(
    costs: NDArray[np.float64], gains: NDArray[np.float64], order: NDArray[np.int64], rate: float
) -> float:
    """Return the value of a tour.

    ``costs`` (K, K) are the distances between places, ``gains`` (K,) their gains, 0 at the start, and ``order`` the
    numbers of the visited places, the start first.
    """
    return float(_value(costs, gains, order, float(rate)))


def improved_tour(
    costs: NDArray[np.float64], gains: NDArray[np.float64], order: NDArray[np.int64], rate: float
) -> tuple[NDArray[np.int64], float]:
    """Move single places of a tour while this increases its value (:func:`value_of_tour`); return order and value."""
    order = order.copy()
    return order, float(_improve(costs, gains, order, float(rate)))
