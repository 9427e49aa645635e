"""The utility of a candidate as the next goal: the best short sequence that begins there, and the cost of the rest.

Both use a :class:`DecisionProblem`, the candidates of a group of UAVs. The value of a sequence is the sum of the gains
of its candidates, discounted by the time of arrival; each view counts once. The search is exhaustive with bounds. The
rest, the clusters that remain, is ordered as in :mod:`indoor_explorers.planners.toolbox.routing.min_latency`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.planners.toolbox.routing.local_search import by_nearest
from indoor_explorers.planners.toolbox.routing.min_latency import improved_cost

#: Largest number of candidates of a sequence.
LENGTH = 3


class DecisionProblem(NamedTuple):
    """K candidates that N UAVs can choose from; distances in lidar ranges, ``UNREACHABLE`` without a path."""

    cells: NDArray[np.int32]
    """(K,) flat cells."""
    ahead: Mask
    """(K,) bool, whether they are frontier clusters; the others are cells near the UAVs."""
    away: NDArray[np.float64]
    """(N, K) distances from the UAVs."""
    between: NDArray[np.float64]
    """(K, K) distances between candidates."""
    gains: NDArray[np.float64]
    """(K,) view gain of each candidate."""
    shared: NDArray[np.float64]
    """(K, K) share of the first one's view that the second one sees, too."""
    hysteresis: NDArray[np.float64]
    """(N, K) factor on the value of a candidate as a UAV's first."""


class Utility(NamedTuple):
    """Parameters of the value of a visit: (remaining gain)^power e^(-rate t) trust^k."""

    power: float
    """Exponent of the gain that remains after earlier candidates of the sequence."""
    rate: float
    """Discount rate per lidar range flown until arrival."""
    trust: float
    """Factor for each of the k candidates before, since the map may differ from expectation."""


@kernel()
def _best(
    away: np.ndarray,
    between: np.ndarray,
    gains: np.ndarray,
    shared: np.ndarray,
    hysteresis: np.ndarray,
    utility: Utility,
    values: np.ndarray,
    sequences: np.ndarray,
) -> None:
    """Fill the results of :func:`best_sequences`; values are 0 and sequences -1 at first."""
    count = away.shape[0]
    power, rate, trust = utility
    largest = 0.0
    for a in range(count):
        largest = max(largest, gains[a])
    most = largest**power
    for a in range(count):
        sequences[a, 0] = a
        if away[a] >= UNREACHABLE:
            continue
        one = gains[a] ** power * np.exp(-rate * away[a]) * hysteresis[a]
        best = one
        for b in range(count):
            if b == a:
                continue
            discount = np.exp(-rate * (away[a] + between[a, b])) * trust
            two = one + (gains[b] * (1.0 - shared[b, a])) ** power * discount
            if two > best:
                best, sequences[a, 1], sequences[a, 2] = two, b, -1
            if two + most * discount * trust <= best:
                continue
            for c in range(count):
                way = rate * between[b, c]
                if c in (a, b) or two + most * discount * trust / (1.0 + way) <= best:  # e^-x < 1 / (1 + x)
                    continue
                left = gains[c] * (1.0 - shared[c, a]) * (1.0 - shared[c, b])
                three = two + left**power * discount * trust * np.exp(-way)
                if three > best:
                    best, sequences[a, 1], sequences[a, 2] = three, b, c
        values[a] = best


def best_sequences(
    problem: DecisionProblem, uav: int, gains: NDArray[np.float64], utility: Utility
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return, for each of K candidates, a UAV's best sequence of up to three that begins there, and its value.

    ``gains`` (K,) are the problem's gains after the teammates' choices. Values are (K,), 0 for unreachable candidates;
    sequences (K, 3) hold indices of candidates, -1 after their end.
    """
    values, sequences = np.zeros(len(gains)), np.full((len(gains), LENGTH), -1, np.int64)
    hysteresis = problem.hysteresis[uav]
    _best(problem.away[uav], problem.between, gains, problem.shared, hysteresis, utility, values, sequences)
    return values, sequences


@kernel()
def _rest(
    first: int, rest: np.ndarray, away: np.ndarray, between: np.ndarray, weights: np.ndarray, latency: float
) -> float:
    count = rest.shape[0] + 1
    start, weight, ways, total = np.empty(count), np.empty(count), np.empty((count, count)), 0.0
    for i in range(count):
        candidate = first if i == 0 else rest[i - 1]
        start[i], weight[i] = away[candidate], weights[candidate]
        total += weight[i]
        for j in range(count):
            ways[i, j] = between[candidate, first if j == 0 else rest[j - 1]]
    for i in range(count):
        weight[i] /= max(total, 1e-300)
    return float(improved_cost(by_nearest(0, ways), start, ways, weight, latency))


def cost_of_rest(
    problem: DecisionProblem,
    uav: int,
    first: int,
    rest: NDArray[np.int64],
    weights: NDArray[np.float64],
    latency: float,
) -> float:
    """Return the cost of a good order of some candidates that begins with ``first``, in lidar ranges.

    ``rest`` are the indices of the others. The cost is the time at which the last one is reached, plus ``latency``
    times the mean waiting time weighted by ``weights`` (K,).
    """
    return float(_rest(first, rest, problem.away[uav], problem.between, weights, latency))
