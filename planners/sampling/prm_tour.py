"""Tours through viewpoints on a probabilistic roadmap, after TARE's local planner (Cao et al. 2021)."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.search.frontiers import frontier_mask
from indoor_explorers.planners.sampling.covers import greedy_cover
from indoor_explorers.planners.sampling.roadmaps import Roadmap, grow_roadmap
from indoor_explorers.planners.sampling.samples import known_cells, points_in
from indoor_explorers.planners.sampling.setting import Points
from indoor_explorers.planners.sampling.viewpoints import ViewpointPilot, ViewpointPolicy, Viewpoints
from indoor_explorers.planners.toolbox.information.view_gain import visible_sets
from indoor_explorers.planners.toolbox.parameters import bounded
from indoor_explorers.planners.toolbox.routing.local_search import Objective, SearchSettings, cost_of, improve
from indoor_explorers.planners.toolbox.routing.open_tours import nearest_neighbour

#: Number of tours that are improved: those of the highest value in nearest-neighbour order.
IMPROVED = 3
#: Largest number of rounds of improvement: practically unlimited.
TOUR_ROUNDS = 2**31
#: Relative improvement that a change must exceed.
LEAST_SHARE = 1e-9


@renamed()
@dataclass(frozen=True, kw_only=True)
class PrmTour(ViewpointPolicy):
    """Select few milestones of a PRM* that view all visible unknown cells, and fly to the first one of a tour.

    A set of milestones that together view all visible unknown cells is picked greedily, at random among the best few,
    several times. The tour with the largest sum of gains, each discounted by its distance, is flown, or, with
    ``as_published``, the shortest tour. The last tour's milestones are candidates again, so that the tour only changes
    for a better one.

    C. Cao, H. Zhu, H. Choset, J. Zhang, "TARE: a hierarchical framework for efficiently exploring complex 3D
    environments", RSS 2021, doi:10.15607/RSS.2021.XVII.018.
    """

    milestones: int = bounded(200, least=1)
    """Milestones of the roadmap, half of them on the frontier if there are enough frontier cells."""
    restarts: int = bounded(10, least=1)
    """Number of covers that are tried for each tour."""
    choices: int = bounded(3, least=1)
    """Number of best milestones that a cover draws from in each round."""
    stops: int = bounded(30, least=1)
    """Most stops of a tour."""
    least: float = bounded(0.002, least=0)
    """Fewest cells that a stop must add to the view, as a share of the lidar's disc."""
    keep: float = bounded(1.2, least=0)
    """Factor on the merit of a tour that is similar to the last one."""
    as_published: bool = False
    """Whether to fly the shortest tour, as in the paper, instead of the one with the largest discounted gain."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return PrmTourPilot(briefing, self)


class PrmTourPilot(ViewpointPilot):
    """Keep milestones from roadmap to roadmap, and the stops of the tour; fly to a stop until it has no gain left."""

    replan_period = inf

    def __init__(self, briefing: Briefing, policy: PrmTour) -> None:
        super().__init__(briefing, policy)
        self._policy = policy
        self._milestones: Points = np.empty((0, 2))
        self._stops = np.empty(0, np.int32)
        disc = np.pi * briefing.lidar_range**2
        self._least = max(1, int(policy.least * disc))
        self._rate = 0.0 if policy.as_published else policy.discount_rate / briefing.lidar_range

    def viewpoint(self, view: View) -> Cell | None:
        """Return the first stop of the best tour."""
        self._milestones = self._sampled(view)
        start = np.array([[view.cell[0] + 0.5, view.cell[1] + 0.5]])
        roadmap = grow_roadmap(view.belief, np.concatenate([start, self._milestones]))
        cells = known_cells(view.belief, roadmap.points)
        joined = np.isfinite(roadmap.lengths_from(0)[0])
        viewpoints = self.judged(view, np.unique(cells[joined])).unclaimed()
        if not len(viewpoints.cells):
            return None
        self._stops = self._tour(view, roadmap, np.where(joined, cells, -1), viewpoints)
        return divmod(int(self._stops[0]), self.paths.width)

    def _sampled(self, view: View) -> Points:
        """Return the milestones: stops of the last tour, cells drawn from the frontier, and any free cells."""
        width, count = self.paths.width, self._policy.milestones
        free = (view.belief == FREE) & ~view.visited
        frontier = np.flatnonzero(frontier_mask(view.belief))
        drawn = self.rng.permutation(frontier)[: count // 2]
        anywhere = self.rng.permutation(np.flatnonzero(view.belief == FREE))[: count - len(drawn)]
        kept = self._stops[free.ravel()[self._stops]]
        return points_in(np.union1d(np.union1d(kept, drawn), anywhere).astype(np.int32), width, self.rng)

    def _tour(
        self, view: View, roadmap: Roadmap, cells: NDArray[np.int32], viewpoints: Viewpoints
    ) -> NDArray[np.int32]:
        """Return the stops of the best tour, (K,) flat cells."""
        bits = visible_sets(view.belief, viewpoints.cells, self.briefing.lidar_range)
        weights = np.exp(-self._rate * viewpoints.steps)
        covers = self._covers(bits, weights, np.flatnonzero(np.isin(viewpoints.cells, self._stops)))
        place = {cell: k for k, cell in enumerate(cells.tolist())}
        used = np.unique(np.concatenate([picks for picks, _ in covers]))
        milestones = [0, *(place[cell] for cell in viewpoints.cells[used].tolist())]
        costs = roadmap.lengths_from(*milestones)[:, milestones]
        totals = np.bitwise_count(bits).sum(axis=1)
        tours = []
        for picks, added in covers:
            places = np.concatenate([[0], 1 + np.searchsorted(used, picks)])
            worths = np.zeros(len(costs))
            worths[places[1:]] = added / totals[picks] * viewpoints.gains[picks]
            tours.append((worths, places[nearest_neighbour(costs[np.ix_(places, places)])]))
        return np.asarray(viewpoints.cells[used[self._best(costs, tours)[1:] - 1]], np.int32)

    def _best(
        self, costs: NDArray[np.float64], tours: list[tuple[NDArray[np.float64], NDArray[np.int64]]]
    ) -> NDArray[np.int64]:
        """Return the improved order of highest value, among the first tour and the most promising others.

        A tour is the places' gains, (K,), and an order of some of them. ``costs`` are (K, K).
        """
        values = [value_of_tour(costs, worths, order, self._rate) for worths, order in tours]
        promising = np.argsort(-np.array(values), kind="stable")[:IMPROVED]
        best, most = tours[0][1], -np.inf
        for k in sorted({0, *promising.tolist()}):
            worths, order = tours[k]
            order, earned = improved_tour(costs, worths, order, self._rate)
            if k == 0:
                earned *= self._policy.keep ** np.sign(earned)
            if earned > most:
                best, most = order, earned
        return best

    def _covers(
        self, bits: NDArray[np.uint64], weights: NDArray[np.float64], kept: NDArray[np.int64]
    ) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]]:
        """Return covers, each as its picks and the cells that they add; the first one begins with the kept stops."""
        policy = self._policy
        least = self._least
        none = np.zeros(policy.stops, np.int64)
        first, gained = greedy_cover(bits[kept], weights[kept], none, least)
        rest = bits & ~np.bitwise_or.reduce(bits[kept], axis=0)
        more, added = (
            greedy_cover(rest, weights, none[len(first) :], least) if len(first) < policy.stops else (none[:0],) * 2
        )
        covers = [(np.concatenate([kept[first], more]), np.concatenate([gained, added]))]
        for _ in range(policy.restarts):
            covers.append(greedy_cover(bits, weights, self.rng.integers(policy.choices, size=policy.stops), least))
        covers = [cover for cover in covers if len(cover[0])]
        return covers or [greedy_cover(bits, weights, none, 1)]


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
