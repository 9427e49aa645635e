"""Tours through covers: few viewpoints that see all, drawn several times, in the order of highest value."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.planners.sampling.covers import greedy_cover
from indoor_explorers.planners.toolbox.parameters import Parameters, bounded
from indoor_explorers.planners.toolbox.routing.local_search import Objective, SearchSettings, cost_of, improve

#: The picks of a cover and the ones that each of them adds, both (P,).
Cover = tuple[NDArray[np.int64], NDArray[np.int64]]

#: Number of tours that are improved: those of the highest value in nearest-neighbour order.
IMPROVED = 3
#: Largest number of rounds of improvement: practically unlimited.
TOUR_ROUNDS = 2**31
#: Relative improvement that a change must exceed.
LEAST_SHARE = 1e-9


@dataclass(frozen=True, kw_only=True)
class CoverParameters(Parameters):
    """How covers are drawn and a tour through one of them is chosen."""

    restarts: int = bounded(10, least=1)
    """Number of covers that are tried for each tour."""
    choices: int = bounded(3, least=1, tunable=(1, 6))
    """Number of best viewpoints that a cover draws from in each round."""
    stops: int = bounded(30, least=1)
    """Most stops of a tour."""
    keep: float = bounded(1.2, least=0, tunable=(1.0, 2.0))
    """Factor on the merit of a tour that is similar to the last one."""

    def covers(
        self,
        bits: NDArray[np.uint64],
        weights: NDArray[np.float64],
        kept: NDArray[np.int64],
        least: int,
        rng: np.random.Generator,
    ) -> list[Cover]:
        """Return covers of the ones of (K, words) ``bits``, the first of which begins with the ``kept`` rows.

        Rows that add fewer than ``least`` ones are left out, unless no cover has a row otherwise.
        """
        none = np.zeros(self.stops, np.int64)
        first, gained = greedy_cover(bits[kept], weights[kept], none, least)
        rest = bits & ~np.bitwise_or.reduce(bits[kept], axis=0)
        more, added = (
            greedy_cover(rest, weights, none[len(first) :], least) if len(first) < self.stops else (none[:0],) * 2
        )
        covers = [(np.concatenate([kept[first], more]), np.concatenate([gained, added]))]
        for _ in range(self.restarts):
            covers.append(greedy_cover(bits, weights, rng.integers(self.choices, size=self.stops), least))
        covers = [cover for cover in covers if len(cover[0])]
        return covers or [greedy_cover(bits, weights, none, 1)]

    def best_tour(
        self, costs: NDArray[np.float64], tours: list[tuple[NDArray[np.float64], NDArray[np.int64]]], rate: float
    ) -> NDArray[np.int64]:
        """Return the improved order of highest value, among the first tour and the most promising others.

        A tour is the places' gains, (K,), and an order of some of them. ``costs`` are (K, K).
        """
        values = [value_of_tour(costs, worths, order, rate) for worths, order in tours]
        promising = np.argsort(-np.array(values), kind="stable")[:IMPROVED]
        best, most = tours[0][1], -np.inf
        for k in sorted({0, *promising.tolist()}):
            worths, order = tours[k]
            order, earned = improved_tour(costs, worths, order, rate)
            if k == 0:
                earned *= self.keep ** np.sign(earned)
            if earned > most:
                best, most = order, earned
        return best


@kernel()
def _value(costs: np.ndarray, gains: np.ndarray, order: np.ndarray, rate: float) -> float:
    return float(-cost_of(order, costs[order[0]], costs, gains, Objective(0.0, rate)))


@kernel()
def _improve(costs: np.ndarray, gains: np.ndarray, order: np.ndarray, rate: float) -> float:
    settings = SearchSettings(TOUR_ROUNDS, False, 0.0, LEAST_SHARE)
    return float(-improve(order, costs[order[0]], costs, gains, Objective(0.0, rate), settings))


def value_of_tour(
    costs: NDArray[np.float64], gains: NDArray[np.float64], order: NDArray[np.int64], rate: float
) -> float:
    """Return the value of a tour: the sum of the gains, discounted by the times of arrival; for ``rate`` 0, -length.

    ``costs`` (K, K) are the distances between stops, ``gains`` (K,) their gains, 0 at the start, and ``order`` the
    numbers of the visited stops, the start first.
    """
    return float(_value(costs, gains, order, float(rate)))


def improved_tour(
    costs: NDArray[np.float64], gains: NDArray[np.float64], order: NDArray[np.int64], rate: float
) -> tuple[NDArray[np.int64], float]:
    """Move single stops of a tour while this increases its value (:func:`value_of_tour`); return order and value."""
    order = order.copy()
    return order, float(_improve(costs, gains, order, float(rate)))
