"""Frontier clusters in an order of low mean waiting time, weighted by their view gains."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Distances
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.coordination.out_of_contact import OutOfContact
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters
from indoor_explorers.planners.toolbox.information.cluster_places import (
    LEFT_TO_OTHERS,
    ClusterPlaces,
    PlaceParameters,
    halved_by_mates,
    log_gains,
    waiting_weights,
)
from indoor_explorers.planners.toolbox.information.lookouts import LookoutPilot, Lookouts
from indoor_explorers.planners.toolbox.navigation.teammates import remembered
from indoor_explorers.planners.toolbox.parameters import bounded
from indoor_explorers.planners.toolbox.pockets.outlook import Outlook
from indoor_explorers.planners.toolbox.routing.min_latency import best_orders

#: An order is kept for this many lidar ranges of flight, unless its first viewpoint has no gain left before.
KEEP = 0.1


@renamed(depth="decay_length", discount="discount_rate", hold="switch_cost")
@dataclass(frozen=True, kw_only=True)
class FrontierLatency(PlaceParameters, Policy):
    """Fly to the first cluster of the best order of all clusters.

    The viewpoint of a cluster is its cell with the largest discounted gain ``g exp(-discount_rate d / R)``, d its
    distance and R the lidar range (H. H. Gonzalez-Banos and J.-C. Latombe, IJRR 2002,
    doi:10.1177/0278364902021010834, with g in cells, near and isolated ones weighted more). The order of these
    viewpoints minimises a travelling repairman's cost: the time at which the last one is reached, plus ``latency``
    times the mean waiting time weighted by gains. It is computed again when the map has changed; an order that
    begins elsewhere must save ``switch_cost``. Paths are the straightest of the shortest ones. The repairman's problem:
    A. Blum et al., "The minimum latency problem", STOC 1994, doi:10.1145/195058.195125.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    sector: float = bounded(0.0, least=0, tunable=(0.0, 6.0))
    """Preference for the UAV's own sector of the map while teammates were never heard; see :class:`OutOfContact`."""
    lookouts: int = bounded(0, least=0, tunable=(0, 16))
    """Most viewpoints near the UAV that need not be at a frontier; where there may be some, viewpoints that share half
    of their view with a better one are left out (:mod:`indoor_explorers.planners.toolbox.information.lookouts`)."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return LatencyPilot(briefing, self)


class ClusterViewpoints(NamedTuple):
    """One viewpoint for each of K clusters."""

    cells: NDArray[np.int32]
    """(K,) flat cells."""
    steps: Distances
    """(K,) distances from the UAV."""
    gains: NDArray[np.float64]
    """(K,) weighted view gains, times the factors for teammates."""
    kept: NDArray[np.bool_]
    """(K,) bool, whether they are at the last goal."""


class LatencyPilot(LookoutPilot):
    """Order the clusters whenever the map has changed, and fly to the first."""

    changes_levels: ClassVar[bool] = True
    straight = True

    def __init__(self, briefing: Briefing, policy: FrontierLatency) -> None:
        super().__init__(briefing)
        self._policy = policy
        self._range = briefing.lidar_range
        self._out_of_contact = OutOfContact(briefing, sector=policy.sector) if policy.sector else None
        self._found = ClusterPlaces(self, policy)
        self.lookouts = Lookouts(self, self._found, policy.discount_rate, policy.lookouts)
        self.replan_period = self.steps_in(KEEP)

    def choose(self, view: View) -> Cell | None:
        """Return the first viewpoint of the order of lowest cost."""
        viewpoints = self._viewpoints(view)
        if len(viewpoints.cells) == 0:
            return None
        costs = self._orders(view, viewpoints)[0] - self._policy.switch_cost * viewpoints.kept
        gains, steps = viewpoints.gains, viewpoints.steps
        self.consider(viewpoints.cells, "cost of the best order, negative", -costs, cost=costs, gain=gains, steps=steps)
        return divmod(int(viewpoints.cells[np.argmin(costs)]), self.paths.width)

    def order(self, view: View) -> list[Cell]:
        """Return the viewpoints of the order of lowest cost, in turn, without the switch cost."""
        viewpoints = self._viewpoints(view)
        positions = self._orders(view, viewpoints)[1]
        return [divmod(int(cell), self.paths.width) for cell in viewpoints.cells[np.argsort(positions)]]

    def outlook(self, view: View, clusters: Clusters, away: Distances) -> Outlook:
        """Return the outlook of K clusters, ``away`` (K,) steps from the UAV: here, the same for all."""
        return Outlook(np.zeros(clusters.size, np.bool_), np.ones(clusters.size))

    def factors(self, view: View, cells: NDArray[np.int32], steps: Distances) -> NDArray[np.float64]:
        """Return the factors on the gains of (K,) flat cells for teammates, (K,) in [0, 1].

        Every teammate that is closer halves a gain; those never heard leave the own sector.
        """
        mates = remembered(view, self.briefing)
        others = [self.steps_from(view, mate.cell).ravel()[cells] for mate in mates]
        halved = halved_by_mates(steps, others, [mate.agent < self.briefing.agent for mate in mates])
        if self._out_of_contact is None:
            return halved
        return halved * self._out_of_contact.left_by_unheard_at_cells(view, cells)

    def _viewpoints(self, view: View) -> ClusterViewpoints:
        """Return the best viewpoints of the best reachable clusters."""
        found = self._found.found(view)
        outlook = self.outlook(view, found.clusters, found.away)
        found = self.lookouts.added_to(view, found)
        wanted = ~outlook.deferred[found.owner]
        found = found.selected(wanted) if wanted.any() and not wanted.all() else found
        factors = self.factors(view, found.cells, found.steps)
        own = factors > LEFT_TO_OTHERS * factors.max(initial=0.0)
        if not own.all():
            found, factors = found.selected(own), factors[own]
        _, _, cells, owner, steps = found
        gains = factors * outlook.chances[owner] * self._found.views(view, cells)
        scores = log_gains(gains) - self._policy.discount_rate * steps / self._range
        kept = self._found.at_goal(cells)
        best = self._found.best_of_each(owner, scores, kept)
        best = best[np.argsort(-scores[best], kind="stable")][: self._policy.clusters]
        best = best[self.lookouts.distinct(view, cells[best])]
        return ClusterViewpoints(cells[best], steps[best], gains[best], kept[best])

    def _orders(self, view: View, viewpoints: ClusterViewpoints) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Return the costs of the best orders that begin at each viewpoint, in lidar ranges, (K,).

        The second array has each viewpoint's position in the best of these orders, (K,).
        """
        if len(viewpoints.cells) <= 1:
            return np.zeros(len(viewpoints.cells)), np.zeros(len(viewpoints.cells), np.int64)
        worth = waiting_weights(viewpoints.gains, self._policy.worth)
        between = self.paths.matrix(view.belief, viewpoints.cells) / self._range
        return best_orders(viewpoints.steps / self._range, between, worth / worth.sum(), self._policy.latency)
