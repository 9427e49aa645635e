"""Tours through viewpoints on a probabilistic roadmap, after TARE's local planner (Cao et al. 2021)."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.search.frontiers import frontier_mask
from indoor_explorers.planners.sampling.cover_tours import CoverParameters
from indoor_explorers.planners.sampling.points import Points, centre, known_cells, points_in
from indoor_explorers.planners.sampling.roadmaps import Roadmap, grow_roadmap
from indoor_explorers.planners.sampling.viewpoints import ViewpointPilot, ViewpointPolicy, Viewpoints
from indoor_explorers.planners.toolbox.information.view_gain import visible_sets
from indoor_explorers.planners.toolbox.parameters import bounded
from indoor_explorers.planners.toolbox.routing.open_tours import nearest_neighbour


@renamed()
@dataclass(frozen=True, kw_only=True)
class PrmTour(CoverParameters, ViewpointPolicy):
    """Select few milestones of a PRM* that view all visible unknown cells, and fly to the first one of a tour.

    A set of milestones that together view all visible unknown cells is picked greedily, at random among the best few,
    several times. The tour with the largest sum of gains, each discounted by its distance, is flown, or, with
    ``as_published``, the shortest tour. The last tour's milestones are candidates again, so that the tour only changes
    for a better one.

    C. Cao, H. Zhu, H. Choset, J. Zhang, "TARE: a hierarchical framework for efficiently exploring complex 3D
    environments", RSS 2021, doi:10.15607/RSS.2021.XVII.018.
    """

    milestones: int = bounded(200, least=1, tunable=(50, 400, "log"))
    """Milestones of the roadmap, half of them on the frontier if there are enough frontier cells."""
    least: float = bounded(0.002, least=0, tunable=(0.0005, 0.02, "log"))
    """Fewest cells that a stop must add to the view, as a share of the lidar's disc."""
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
        self._milestones: Points = np.empty((0, self.axes))
        self._stops = np.empty(0, np.int32)
        self._least = max(1, int(policy.least * self.largest_view))
        self._rate = 0.0 if policy.as_published else policy.discount_rate / briefing.lidar_range

    def viewpoint(self, view: View) -> Cell | None:
        """Return the first stop of the best tour."""
        self._milestones = self._sampled(view)
        rise, points = self.paths.rise, np.concatenate([[centre(view.cell, self.paths.rise)], self._milestones])
        roadmap = grow_roadmap(view.belief, points, rise)
        cells = known_cells(view.belief, roadmap.points, rise)
        joined = np.isfinite(roadmap.lengths_from(0)[0])
        viewpoints = self.judged(view, np.unique(cells[joined])).unclaimed()
        if not len(viewpoints.cells):
            return None
        self._stops = self._tour(view, roadmap, np.where(joined, cells, -1), viewpoints)
        steps = self.steps_from(view, view.cell).ravel()[self._stops]
        self.consider(self._stops, "place in the tour, negative", -1.0 - np.arange(len(self._stops)), steps=steps)
        return divmod(int(self._stops[0]), self.paths.width)

    def _sampled(self, view: View) -> Points:
        """Return the milestones: stops of the last tour, cells drawn from the frontier, and any free cells."""
        count = self._policy.milestones
        free = (view.belief == FREE) & ~view.visited
        frontier = np.flatnonzero(frontier_mask(view.belief, self.paths.rise))
        drawn = self.rng.permutation(frontier)[: count // 2]
        anywhere = self.rng.permutation(np.flatnonzero(view.belief == FREE))[: count - len(drawn)]
        kept = self._stops[free.ravel()[self._stops]]
        cells = np.union1d(np.union1d(kept, drawn), anywhere).astype(np.int32)
        return points_in(cells, self.paths.width, self.paths.rise, self.rng)

    def _tour(
        self, view: View, roadmap: Roadmap, cells: NDArray[np.int32], viewpoints: Viewpoints
    ) -> NDArray[np.int32]:
        """Return the stops of the best tour, (K,) flat cells."""
        bits = visible_sets(view.belief, viewpoints.cells, self.lidar)
        weights = np.exp(-self._rate * viewpoints.steps)
        kept = np.flatnonzero(np.isin(viewpoints.cells, self._stops))
        covers = self._policy.covers(bits, weights, kept, self._least, self.rng)
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
        return np.asarray(viewpoints.cells[used[self._policy.best_tour(costs, tours, self._rate)[1:] - 1]], np.int32)
