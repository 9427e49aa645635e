"""Tours through few viewpoints that see the whole frontier, after TARE (Cao et al. 2021)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell, Distances, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN, UNREACHABLE
from indoor_explorers.env.grid.levels import plane_of
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.search.frontiers import frontier_mask
from indoor_explorers.env.sensing.lidar import LidarModel
from indoor_explorers.planners.sampling.cover_tours import CoverParameters
from indoor_explorers.planners.sampling.points import extent
from indoor_explorers.planners.sampling.viewpoints import ViewpointPilot, ViewpointPolicy, Viewpoints
from indoor_explorers.planners.toolbox.frontiers.clusters import middles
from indoor_explorers.planners.toolbox.information.candidates import distances_between
from indoor_explorers.planners.toolbox.information.view_gain import visible_sets
from indoor_explorers.planners.toolbox.parameters import bounded
from indoor_explorers.planners.toolbox.routing.open_tours import nearest_neighbour


@renamed()
@dataclass(frozen=True, kw_only=True)
class CoverTour(CoverParameters, ViewpointPolicy):
    """Select few viewpoints that together see all frontier cells, and fly to the first one of a tour.

    As in ``prm-tour``, covers are drawn several times and the tour of the highest value is flown, but a cover has to
    see the frontier from near, not all unknown cells that may be in view from afar: walls behind a frontier are not
    known yet. Viewpoints lie on a lattice and in the middle of each frontier cluster. With ``as_published`` the
    shortest tour is flown.

    C. Cao, H. Zhu, H. Choset, J. Zhang, "TARE: a hierarchical framework for efficiently exploring complex 3D
    environments", RSS 2021, doi:10.15607/RSS.2021.XVII.018.
    """

    keep: float = 1.0
    stops: int = 40
    reach: float = bounded(0.8, least=0.1, most=1, tunable=(0.4, 1.0))
    """Distance from which a viewpoint sees a frontier cell, in lidar ranges."""
    spacing: float = bounded(0.2, least=0, tunable=(0.1, 0.6))
    """Distance between the viewpoints of the lattice, in lidar ranges; at least a cell."""
    period: float = bounded(0.2, least=0, tunable=(0.05, 1.0, "log"))
    """Length of flight after which the UAV chooses again if the map has grown, in lidar ranges."""
    as_published: bool = False
    """Whether to fly the shortest tour."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return CoverTourPilot(briefing, self)


class CoverTourPilot(ViewpointPilot):
    """Keep the stops of the tour, which are viewpoints again; fly to the first one of the best tour."""

    def __init__(self, briefing: Briefing, policy: CoverTour) -> None:
        super().__init__(briefing, policy)
        self._policy = policy
        self._stops = np.empty(0, np.int32)
        self.replan_period = policy.period * briefing.lidar_range
        self._rate = 0.0 if policy.as_published else policy.discount_rate / briefing.lidar_range
        self._lattice = lattice(briefing.shape, max(1, round(policy.spacing * briefing.lidar_range)), self.paths.rise)
        self._near = self.lidar_of(float(policy.reach * briefing.lidar_range))

    def viewpoint(self, view: View) -> Cell | None:
        """Return the first stop of the best tour."""
        viewpoints = self.judged(view, self._candidates(view)).unclaimed()
        field = self.steps_from(view, view.cell)
        bits = visible_frontier(view.belief, field, viewpoints.cells, self._near, self.paths.rise)
        useful = np.flatnonzero(bits.any(axis=1))
        if not len(useful):
            return None
        self._stops = self._tour(view, viewpoints.selected(useful), bits[useful])
        steps = field.ravel()[self._stops]
        self.consider(self._stops, "place in the tour, negative", -1.0 - np.arange(len(self._stops)), steps=steps)
        return divmod(int(self._stops[0]), self.paths.width)

    def _candidates(self, view: View) -> NDArray[np.int32]:
        """Return the flat cells (K,) of the lattice, in the middle of frontier clusters, and of the last tour."""
        regular = np.flatnonzero(self._lattice & (view.belief == FREE))
        ends = middles(self.clusters(view), self.paths.width, self.paths.rise)
        return np.union1d(np.union1d(regular, ends), self._stops).astype(np.int32)

    def _tour(self, view: View, viewpoints: Viewpoints, bits: NDArray[np.uint64]) -> NDArray[np.int32]:
        """Return the stops of the best tour, (K,) flat cells."""
        kept = np.flatnonzero(np.isin(viewpoints.cells, self._stops))
        covers = self._policy.covers(bits, np.ones(len(bits)), kept, 1, self.rng)
        used = np.unique(np.concatenate([picks for picks, _ in covers]))
        costs = self._lengths(view, viewpoints.selected(used))
        totals = np.bitwise_count(bits).sum(axis=1)
        tours = []
        for picks, added in covers:
            places = np.concatenate([[0], 1 + np.searchsorted(used, picks)])
            worths = np.zeros(len(costs))
            worths[places[1:]] = added / totals[picks] * viewpoints.gains[picks]
            tours.append((worths, places[nearest_neighbour(costs[np.ix_(places, places)])]))
        order = self._policy.best_tour(costs, tours, self._rate)
        return np.asarray(viewpoints.cells[used[order[1:] - 1]], np.int32)

    def _lengths(self, view: View, viewpoints: Viewpoints) -> NDArray[np.float64]:
        """Return the steps between the UAV, place 0, and (K,) viewpoints, (K + 1, K + 1)."""
        cells = np.concatenate([self.paths.flat([view.cell]), viewpoints.cells])
        steps = np.concatenate([[0], viewpoints.steps])[None]
        return np.asarray(distances_between(view.belief, cells, steps, view.belief.size, self.paths.rise))


def lattice(shape: tuple[int, int], apart: int, rise: int) -> Mask:
    """Return the cells of a (H, W) plane that are ``apart`` cells from each other along all axes, (H, W) bool."""
    levels, *size = (1, *extent(shape, rise))[-3:]
    spacings = (min(apart, levels), apart, apart)
    axes = [np.arange(length) % each == each // 2 for length, each in zip((levels, *size), spacings, strict=True)]
    return plane_of(np.logical_and.outer(axes[0], np.logical_and.outer(axes[1], axes[2])), between=False)


def visible_frontier(
    belief: Belief, steps: Distances, cells: NDArray[np.int32], reach: LidarModel | float, rise: int = 0
) -> NDArray[np.uint64]:
    """Return the frontier cells in sight of each of (K,) flat cells as bit sets, (K, words) uint64.

    Those are the free cells beside unknown ones that the (H, W) ``steps`` reach, at most ``reach`` cells away, with
    only known free cells between. ``reach`` may be given as the lidar that sees so far.
    """
    marked = np.where(belief == UNKNOWN, OCCUPIED, belief).astype(np.uint8)
    reachable = frontier_mask(belief, rise) & (steps < UNREACHABLE)
    marked[reachable] = UNKNOWN  # which the lidar sees through, and is counted
    return visible_sets(marked, cells, reach)
