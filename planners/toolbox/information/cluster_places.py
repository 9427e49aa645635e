"""Viewpoints of frontier clusters: for each cluster, the cell with the largest view gain for the path length.

``frontier-latency`` and ``frontier-predictive`` order these viewpoints ("places" in the names), and the network of
``dddqn-places`` chooses among them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Distances, Mask
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.view import View
from indoor_explorers.planners.toolbox.frontiers.clusters import (
    Clusters,
    cluster_viewpoints,
    first_of_each,
    nearest_cells,
)
from indoor_explorers.planners.toolbox.information.view_gain import WeightedGains
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.teammates import ranks
from indoor_explorers.planners.toolbox.parameters import (
    DiscountParameters,
    GainParameters,
    SwitchCostParameters,
    bounded,
)

#: Spacing of the cells of a cluster that are considered, in lidar ranges.
STRIDE = 0.3
#: Distance in lidar ranges within which a cell counts as the last goal.
SAME = 0.2
#: Factor on a gain for each teammate that is closer.
CLOSER_MATE = 0.5
#: A cluster is left to teammates if its factor is at most this share of the best one.
LEFT_TO_OTHERS = 0.5
#: Smallest gain that counts, so that gains of 0 have a logarithm.
LEAST = 1e-9


@dataclass(frozen=True, kw_only=True)
class PlaceParameters(GainParameters, DiscountParameters, SwitchCostParameters):
    """Parameters by which the viewpoints of clusters are found and ordered."""

    discount_rate: float = 2.4
    """Discount rate of gains per lidar range of distance, in the choice of a cluster's cell."""
    latency: float = bounded(16.0, least=0, tunable=(1.0, 100.0, "log"))
    """Weight of the mean waiting time relative to the length of the order."""
    worth: float = bounded(0.5, least=0, tunable=(0.0, 1.5))
    """Exponent of gains as weights of waiting times; 0 weights all clusters equally."""
    clusters: int = bounded(12, least=1, tunable=(4, 24))
    """Largest number of clusters in an order: those with the largest discounted gains."""


class PlaceCells(NamedTuple):
    """The possible viewpoints of K clusters."""

    clusters: Clusters
    """All K clusters, unreachable ones included."""
    away: Distances
    """(K,) steps to the nearest cell of each cluster, ``UNREACHABLE`` without a known path."""
    cells: NDArray[np.int32]
    """(L,) flat cells of clusters, a sample of each, that are reachable and not near a banned goal; lookouts behind."""
    owner: NDArray[np.int64]
    """(L,) numbers of their clusters, in ascending order; those of lookouts behind, in any order."""
    steps: Distances
    """(L,) steps to them."""

    def selected(self, chosen: Mask) -> PlaceCells:
        """Return the cells that an (L,) mask selects, with all clusters."""
        return self._replace(cells=self.cells[chosen], owner=self.owner[chosen], steps=self.steps[chosen])


class ClusterPlaces:
    """Find the viewpoints of one UAV.

    Args:
        pilot: The pilot that flies to them.
        parameters: How gains are weighed.
        stride: Spacing of the cells of a cluster that are considered, in lidar ranges.
        same: Distance within which a cell counts as the last goal, in lidar ranges; at least one cell.

    """

    def __init__(
        self, pilot: GoalPilot, parameters: PlaceParameters, *, stride: float = STRIDE, same: float = SAME
    ) -> None:
        lidar = pilot.briefing.lidar_range
        self._pilot = pilot
        self._gains = WeightedGains(pilot.briefing.shape, pilot.lidar, parameters.decay_length, parameters.isolation)
        self._stride, self._same = stride * lidar, max(1.0, same * lidar)
        self._switch_cost = parameters.switch_cost

    def found(self, view: View) -> PlaceCells:
        """Return the L possible viewpoints of the K clusters of a view's (H, W) belief."""
        clusters = self._pilot.clusters(view)
        field = self._pilot.steps_from(view, view.cell)
        nearest, away = nearest_cells(field, clusters)
        cells, owner = cluster_viewpoints(clusters, nearest, self._stride)
        steps = field.ravel()[cells]
        fine = (steps < UNREACHABLE) & ~self._pilot.near_banned(view, cells)
        return PlaceCells(clusters, away, cells[fine], owner[fine], steps[fine])

    def views(self, view: View, cells: NDArray[np.int32]) -> NDArray[np.float64]:
        """Return the weighted view gains of (L,) flat cells, (L,)."""
        return self._gains.at(view.belief, cells)

    def at_goal(self, cells: NDArray[np.int32]) -> Mask:
        """Return which of (L,) flat cells count as the last goal, (L,) bool."""
        return self._pilot.near_goal(self._pilot.goal, cells, self._same, np.maximum)

    def best_of_each(self, owner: NDArray[np.int64], scores: NDArray[np.float64], at_goal: Mask) -> NDArray[np.int64]:
        """Return the index of the cell with the best score of each cluster, of (L,); the last goal has a bonus."""
        return first_of_each(owner, scores + self._switch_cost * at_goal)


def log_gains(gains: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the logarithms of (L,) gains, (L,)."""
    return np.asarray(np.log(np.maximum(gains, LEAST)))


def waiting_weights(gains: NDArray[np.float64], worth: float) -> NDArray[np.float64]:
    """Return the weights of the waiting times at (K,) viewpoints, their gains to the power ``worth``, (K,)."""
    return np.asarray(np.maximum(gains, LEAST) ** worth)


def halved_by_mates(steps: Distances, others: Sequence[Distances], before: Sequence[bool]) -> NDArray[np.float64]:
    """Return the factors on the gains of (L,) cells, half for every teammate that is closer (Bautin et al. 2012), (L,).

    Args:
        steps: (L,) steps from the UAV.
        others: (L,) steps from each teammate.
        before: Whether a teammate that is as close counts as closer.

    """
    return np.asarray(CLOSER_MATE ** ranks(steps, others, before))
