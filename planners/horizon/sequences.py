"""Beam search over the order in which frontier clusters are visited, for maps too large to plan cell by cell."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from indoor_explorers.env.arrays import Belief, Cell
from indoor_explorers.env.compiled import inner, kernel
from indoor_explorers.env.grid import UNKNOWN, UNREACHABLE
from indoor_explorers.env.lidar import Optics, new_scan, optics, visible_cells
from indoor_explorers.env.view import Briefing, View
from indoor_explorers.planners.clusters import frontier_clusters, nearest_cells
from indoor_explorers.planners.frontier.minpos import ranks
from indoor_explorers.planners.gains import bit_count
from indoor_explorers.planners.goals import GoalPilot
from indoor_explorers.planners.horizon.cellsets import insert
from indoor_explorers.planners.teammates import remembered

_ONE = np.uint64(1)
#: How far the surroundings of a cell reach, in lidar ranges.
SURROUNDINGS = 0.25


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
    isolation: float
    """Extra weight of an unknown cell with nothing unknown around it."""


@inner()
def _gain(seen: np.ndarray, sight: np.ndarray, weights: np.ndarray) -> float:
    """Return the weight of the cells in ``sight`` that are not yet in ``seen``."""
    gain = 0.0
    for w in range(seen.shape[0]):
        new = sight[w] & ~seen[w]
        while new != 0:
            lowest = new & (~new + _ONE)
            new ^= lowest
            gain += weights[w * 64 + int(np.int64(bit_count(lowest - _ONE)))]
    return gain


@kernel()
def _sights(belief: np.ndarray, worth: np.ndarray, cells: np.ndarray, lens: Optics) -> tuple[np.ndarray, np.ndarray]:
    width = belief.shape[1]
    scan = new_scan(lens)
    number = np.full(belief.size, -1, np.int64)
    weights = np.zeros(min(belief.size, cells.shape[0] * (lens.disc + 1)) + 64)
    bits = np.zeros((cells.shape[0], weights.shape[0] // 64), np.uint64)
    total = 0
    for k in range(cells.shape[0]):
        for place in range(visible_cells(belief, cells[k] // width, cells[k] % width, lens, scan)):
            cell = scan.cells[place]
            if belief[cell // width, cell % width] == UNKNOWN:
                if number[cell] < 0:
                    number[cell] = total
                    weights[total] = worth[cell // width, cell % width]
                    total += 1
                insert(bits[k], number[cell])
    return bits[:, : (total + 63) // 64].copy(), weights


def isolation_weights(belief: Belief, radius: int, isolation: float) -> NDArray[np.float64]:
    """Return the weight of each cell of a (H, W) belief: 1 + ``isolation`` x the share of its surroundings known.

    The surroundings are the square of cells up to ``radius`` away; off the map counts as known.
    """
    unknown = ndimage.uniform_filter((belief == UNKNOWN).astype(np.float64), 2 * radius + 1, mode="constant")
    return np.asarray(1.0 + isolation * (1.0 - unknown))


@kernel()
def gains_alone(sight: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the weight of what is seen from each of K cells by itself, (K,)."""
    nothing = np.zeros(sight.shape[1], np.uint64)
    gains = np.empty(sight.shape[0])
    for k in range(sight.shape[0]):
        gains[k] = _gain(nothing, sight[k], weights)
    return gains


@kernel()
def best_first(
    start: np.ndarray,
    between: np.ndarray,
    sight: np.ndarray,
    weights: np.ndarray,
    shares: np.ndarray,
    decay: float,
    visits: int,
    width: int,
) -> int:
    """Return which of K clusters the best sequence begins with.

    A sequence earns at each visit the share of the newly seen weight times e^(-decay t), t the steps flown until then.
    ``start`` (K,) are steps from the UAV, ``between`` (K, K) steps between clusters, ``sight`` (K, W) the unknown
    cells seen from each as bits, ``weights`` (64 W,) what they are worth, ``shares`` (K,) factors of gains. The
    ``width`` best sequences of n visits are continued by every cluster they lack; they end after ``visits``.
    """
    count, words = sight.shape
    seen, went = np.zeros((1, words), np.uint64), np.zeros((1, count), np.bool_)
    value, time, last, first = np.zeros(1), np.zeros(1), np.full(1, -1), np.full(1, -1)
    for _ in range(min(visits, count)):
        worth, then = np.full(value.shape[0] * count, -1.0), np.zeros(value.shape[0] * count)
        for s in range(value.shape[0]):
            for k in range(count):
                if not went[s, k]:
                    steps = time[s] + (start[k] if last[s] < 0 else between[last[s], k])
                    gain = shares[k] * _gain(seen[s], sight[k], weights)
                    worth[s * count + k], then[s * count + k] = value[s] + gain * np.exp(-decay * steps), steps
        order = np.argsort(-worth, kind="mergesort")[:width]
        order = order[worth[order] >= 0]
        states, last = order // count, order % count
        seen, went, first = seen[states] | sight[last], went[states], np.where(first[states] < 0, last, first[states])
        for n in range(order.shape[0]):
            went[n, last[n]] = True
        value, time = worth[order], then[order]
    return int(first[0])


class SequencePilot(GoalPilot):
    """Fly to the first cluster of the sequence that shows most, soonest."""

    def __init__(self, briefing: Briefing, outlook: Outlook) -> None:
        super().__init__(briefing)
        self._outlook = outlook
        self._lens = optics(float(briefing.lidar_range))
        self._decay = outlook.decay / briefing.lidar_range

    def choose(self, view: View) -> Cell | None:
        """Return the nearest cell of the first cluster; the nearest frontier cell when no cluster shows anything."""
        cells, steps = self._clusters(view)
        if len(cells) == 0:
            return None
        radius = max(2, round(SURROUNDINGS * self.briefing.lidar_range))
        worth = isolation_weights(view.belief, radius, self._outlook.isolation)
        sight, weights = _sights(view.belief, worth, cells, self._lens)
        shares = self._shares(view, cells, steps)
        alone = shares * gains_alone(sight, weights) * np.exp(-self._decay * steps)
        if not alone.any():
            return divmod(int(cells[np.argmin(steps)]), self.paths.width)
        best = np.argsort(-alone, kind="stable")[: self._outlook.candidates]
        cells, start = cells[best], steps[best].astype(np.float64)
        between = np.stack([self._steps_between(view, cell, cells) for cell in cells.tolist()])
        rules = self._decay, self._outlook.visits, self._outlook.width
        first = best_first(start, between, sight[best], weights, shares[best], *rules)
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
