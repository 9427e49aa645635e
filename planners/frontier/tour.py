"""Tour: plan a short tour through the nearest frontier clusters and fly to the first of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.frontier.group_pilot import ClusterChoices, GroupPilot
from indoor_explorers.planners.toolbox.frontiers.clusters import middles
from indoor_explorers.planners.toolbox.navigation.paths import Paths
from indoor_explorers.planners.toolbox.parameters import SwitchCostParameters, bounded
from indoor_explorers.planners.toolbox.routing.open_tours import open_tour, shared_out


@renamed(hold="switch_cost")
@dataclass(frozen=True, kw_only=True)
class FrontierTour(SwitchCostParameters, Policy):
    """Fly to the first cluster of a short open tour through the nearest frontier clusters.

    B. Zhou, Y. Zhang, X. Chen, S. Shen, "FUEL", IEEE RA-L 6(2), 2021, doi:10.1109/LRA.2021.3051563, section V-B, on
    breadth-first distances. A team first divides the clusters by an auction that keeps the longest tour short, as
    B. Zhou, H. Xu, S. Shen, "RACER", IEEE T-RO 39(3), 2023, doi:10.1109/TRO.2023.3236945, balances its partition.

    Such tours oscillate if two of them have almost the same length and every scan changes which one is shorter.
    Therefore the distance to a cluster is that to its nearest cell, not to its centre, which moves while it is
    explored; and the first cluster of the tour is kept, by its position, when clusters change shape.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    switch_cost: float = 0.3
    clusters: int = bounded(30, least=1, tunable=(6, 60))
    """Largest number of clusters on the tours of a group: the nearest to any of its UAVs."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return TourPilot(briefing, self)


class TourPilot(GroupPilot):
    """Divide the clusters among the group, and begin the tour through this UAV's own."""

    def __init__(self, briefing: Briefing, policy: FrontierTour) -> None:
        super().__init__(briefing)
        self._policy = policy
        self._between = DistanceCache(self.paths)

    def assigned(self, view: View, choices: ClusterChoices) -> int:
        """Return the first cluster of this UAV's tour."""
        at_hand = np.arange(min(self._policy.clusters, len(choices.numbers)))  # they are sorted by distance
        uavs, count = len(choices.steps), len(at_hand)
        costs = np.zeros((uavs + count, uavs + count))
        costs[:uavs, uavs:] = choices.costs(self._policy.switch_cost * self.briefing.lidar_range)[:, at_hand]
        places = middles(choices.clusters, self.paths.width, self.paths.rise)[choices.numbers[at_hand]]
        costs[uavs:, uavs:] = self._between.steps(view.belief, places)
        own = np.flatnonzero(shared_out(costs, uavs) == choices.me) if uavs > 1 else at_hand
        if not len(own):
            return int(choices.steps[choices.me].argmin())
        nodes = np.concatenate([[choices.me], uavs + own])
        among = costs[np.ix_(nodes, nodes)]
        if self.explaining:
            stops = own[open_tour(among)[1:] - 1]
            cells, steps = choices.cells[choices.me, stops], choices.steps[choices.me, stops]
            self.consider(cells, "place in the tour, negative", -1.0 - np.arange(len(stops)), steps=steps)
        return int(own[self.first_of_tour(among)])

    def first_of_tour(self, costs: NDArray[np.float64]) -> int:
        """Return the place, of K, that a short open tour visits first; ``costs`` (K + 1, K + 1) has the start first."""
        return int(open_tour(costs)[1] - 1)


class DistanceCache:
    """Steps between places, reused from one tour to the next.

    A cached distance can be longer than the shortest path on a map that has grown since, never shorter.
    """

    def __init__(self, paths: Paths) -> None:
        self._paths = paths
        self._places = np.empty(0, np.int32)
        self._steps = np.empty((0, 0), np.int32)

    def steps(self, belief: Belief, places: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return the (K, K) steps between (K,) different flat cells, searching only from new ones."""
        _, before, now = np.intersect1d(self._places, places, return_indices=True)
        known = np.full((len(places), len(places)), -1, np.int32)
        known[np.ix_(now, now)] = self._steps[np.ix_(before, before)]
        self._places, self._steps = places, self._paths.matrix(belief, places, known)
        return self._steps
