"""Beam search over the order in which frontier clusters are visited, for maps too large to plan cell by cell."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Cell
from indoor_explorers.env.compiled import inner, kernel
from indoor_explorers.env.grid import UNREACHABLE
from indoor_explorers.env.view import Briefing, View
from indoor_explorers.planners.clusters import frontier_clusters, nearest_cells
from indoor_explorers.planners.frontier.minpos import ranks
from indoor_explorers.planners.gains import bit_count, sights
from indoor_explorers.planners.goals import GoalPilot
from indoor_explorers.planners.teammates import remembered


class Outlook(NamedTuple):
    """How far sequences of clusters reach."""

    decay: float
    """Share of a gain that is lost with each lidar range flown before it is had."""
    visits: int
    """Clusters in a sequence."""
    candidates: int
    """Clusters to choose from, those best on their own."""
    width: int
    """Sequences kept after each visit."""
    deference: float
    """Share of a gain that stays with each teammate nearer to the cluster."""


@inner()
def _gain(seen: np.ndarray, sight: np.ndarray) -> int:
    """Count the cells in ``sight`` that are not yet in ``seen``."""
    count = np.uint64(0)
    for w in range(seen.shape[0]):
        count += bit_count(sight[w] & ~seen[w])
    return int(np.int64(count))


@kernel()
def best_first(
    start: np.ndarray, between: np.ndarray, sight: np.ndarray, shares: np.ndarray, decay: float, visits: int, width: int
) -> int:
    """Return which of K clusters the best sequence begins with.

    A sequence earns at each visit the share of the newly seen cells times e^(-decay t), t the steps flown until then.
    ``start`` (K,) are steps from the UAV, ``between`` (K, K) steps between clusters, ``sight`` (K, W) the unknown
    cells seen from each as bits, ``shares`` (K,) weights of their gains. The ``width`` best sequences of n visits are
    continued by every cluster they lack; sequences end after ``visits`` of them.
    """
    count, words = sight.shape
    seen, went = np.zeros((1, words), np.uint64), np.zeros((1, count), np.bool_)
    value, time, last, first = np.zeros(1), np.zeros(1), np.full(1, -1), np.full(1, -1)
    for _ in range(min(visits, count)):
        worth = np.full(value.shape[0] * count, -1.0)
        for s in range(value.shape[0]):
            for k in range(count):
                if not went[s, k]:
                    steps = time[s] + (start[k] if last[s] < 0 else between[last[s], k])
                    gain = shares[k] * _gain(seen[s], sight[k])
                    worth[s * count + k] = value[s] + gain * np.exp(-decay * steps)
        order = np.argsort(-worth, kind="mergesort")[:width]
        order = order[worth[order] >= 0]
        states, ks = order // count, order % count
        seen, went, first = seen[states] | sight[ks], went[states], np.where(first[states] < 0, ks, first[states])
        flown = time[states]
        for n in range(order.shape[0]):
            flown[n] += start[ks[n]] if last[states[n]] < 0 else between[last[states[n]], ks[n]]
            went[n, ks[n]] = True
        value, time, last = worth[order], flown, ks
    return int(first[0])


class SequencePilot(GoalPilot):
    """Fly to the first cluster of the sequence that shows most, soonest."""

    def __init__(self, briefing: Briefing, outlook: Outlook) -> None:
        super().__init__(briefing)
        self._outlook = outlook
        self._decay = outlook.decay / briefing.lidar_range

    def choose(self, view: View) -> Cell | None:
        """Return the nearest cell of the first cluster; the nearest frontier cell when no cluster shows anything."""
        cells, steps = self._clusters(view)
        if len(cells) == 0:
            return None
        sight = sights(view.belief, cells, self.briefing.lidar_range)
        shares = self._shares(view, cells, steps)
        alone = shares * np.bitwise_count(sight).sum(axis=1) * np.exp(-self._decay * steps)
        if not alone.any():
            return divmod(int(cells[np.argmin(steps)]), self.paths.width)
        best = np.argsort(-alone, kind="stable")[: self._outlook.candidates]
        cells = cells[best]
        between = np.stack([self._steps_between(view, cell, cells) for cell in cells.tolist()])
        outlook = self._outlook
        first = best_first(
            steps[best].astype(np.float64),
            between,
            sight[best],
            shares[best],
            self._decay,
            outlook.visits,
            outlook.width,
        )
        return divmod(int(cells[first]), self.paths.width)

    def _clusters(self, view: View) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Return the nearest cells of the clusters that can be reached and are not left alone, and their distances."""
        clusters = frontier_clusters(view.belief, self.briefing.lidar_range)
        cells, steps = nearest_cells(self.paths.field(view.belief, view.cell), clusters)
        good = (steps < UNREACHABLE) & ~self.shunned(view, cells)
        return cells[good], steps[good]

    def _steps_between(self, view: View, start: int, cells: NDArray[np.int32]) -> NDArray[np.float64]:
        return self.paths.field(view.belief, divmod(start, self.paths.width)).ravel()[cells].astype(np.float64)

    def _shares(self, view: View, cells: NDArray[np.int32], own: NDArray[np.int32]) -> NDArray[np.float64]:
        """Return the share of each cluster's gain that is this UAV's, (K,)."""
        mates = remembered(view, self.briefing)
        others = [self.paths.field(view.belief, mate.cell).ravel()[cells] for mate in mates]
        rank = ranks(own, others, [mate.agent < self.briefing.agent for mate in mates])
        return np.asarray(self._outlook.deference**rank)
