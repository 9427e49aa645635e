"""MRTSP: the frontier cluster with the smallest ratio of path cost to size."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.frontier.burgard import SequentialParameters, SequentialPilot
from indoor_explorers.planners.frontier.group_pilot import ClusterChoices
from indoor_explorers.planners.toolbox.parameters import bounded


@dataclass(frozen=True, kw_only=True)
class FrontierMrtsp(SequentialParameters, Policy):
    """Fly to the frontier cluster that comes first in a greedy minimum-ratio travelling salesman tour.

    The ratio of a cluster is its path cost, d + 2 v - R, by its number of cells: d the steps to its nearest cell, v the
    distance from there to its mean, R the lidar range; it is negative within the lidar range. The first cluster also
    costs the smaller of the steps to it and the quarter turns towards it. Source: C. Liu et al., "Enhancing autonomous
    exploration for robotics via real time map optimization and improved frontier costs", Scientific Reports 15, 2025,
    doi:10.1038/s41598-025-97231-9, as M. Guler's ROS 2 package mrtsp_exploration_ros2 documents it. The filtering of
    the map is left out: maps of cells have no stray readings. Teams take the clusters in turn as in
    :mod:`indoor_explorers.planners.frontier.burgard`.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    start_weight: float = bounded(1.0, least=0, tunable=(0.1, 10.0, "log"))
    """Weight of the first cluster's steps or quarter turns."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return MrtspPilot(briefing, self)


class MrtspPilot(SequentialPilot):
    """Score pairs of UAV and cluster by the ratio of cost to size."""

    def __init__(self, briefing: Briefing, policy: FrontierMrtsp) -> None:
        super().__init__(briefing, policy.switch_cost, policy.weight, policy.reach)
        self._policy = policy
        self._before: Cell | None = None
        self._spread = self._start = np.empty((0, 0))

    def gains(self, view: View, choices: ClusterChoices) -> NDArray[np.float64]:
        """Return the size of each cluster, (K,); note what :meth:`score` adds to the costs of each pair."""
        ends, places = choices.clusters.ends, self.coordinates(choices.clusters.cells)
        sizes = np.diff(ends)
        means = (np.add.reduceat(places, ends[:-1]) / sizes[:, None])[choices.numbers]
        spread = np.hypot.reduce(self.coordinates(choices.cells) - means, axis=-1)
        self._spread = spread * 2.0 - self.briefing.lidar_range
        self._start = np.zeros(choices.steps.shape)
        self._start[choices.me] = np.minimum(choices.steps[choices.me], self._quarter_turns(view.cell, means))
        self._before = view.cell
        return sizes[choices.numbers].astype(np.float64)

    def score(self, gains: NDArray[np.float64], costs: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the negative ratios (N, K) of pairs of UAV and cluster."""
        return -((costs + self._spread) / gains + self._policy.start_weight * self._start)

    def _quarter_turns(self, cell: Cell, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the angles (K,) between the last flight and the way to each of (K, D) places, in quarter turns."""
        flown = self.coordinates(cell) - self.coordinates(self._before or cell)
        ways = places - self.coordinates(cell)
        if self.paths.rise > 0:
            angles = np.arctan2(np.linalg.norm(np.cross(ways, flown), axis=-1), ways @ flown)
        else:
            turned = np.arctan2(*ways.T) - np.arctan2(*flown)
            angles = np.abs((turned + np.pi) % (2 * np.pi) - np.pi)
        return np.asarray(angles * (2 / np.pi) * flown.any())
