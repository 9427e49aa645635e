"""Tours by their discounted gains: the sum of what the places are worth, each discounted by when it is reached.

With a discount rate of 0 a tour's value is its negative length.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.planners.routing.local_search import Objective, SearchSettings, cost_of, improve

#: Rounds of improvement: until nothing is found any more.
ROUNDS = 2**31
#: A tour must be worth more by this share.
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

    ``costs`` (K, K) are the distances between places, ``gains`` (K,) what each is worth, 0 at the start, and ``order``
    the numbers of the places visited, the start in front.
    """
    return float(_value(costs, gains, order, float(rate)))


def improved_tour(
    costs: NDArray[np.float64], gains: NDArray[np.float64], order: NDArray[np.int64], rate: float
) -> tuple[NDArray[np.int64], float]:
    """Move single places of a tour while that adds to its value (:func:`value_of_tour`); return order and value."""
    order = order.copy()
    return order, float(_improve(costs, gains, order, float(rate)))
