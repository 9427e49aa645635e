"""Frontier cells by the blocks of an octree, and the block with the most unknown cells in view for each step."""

from __future__ import annotations

from dataclasses import dataclass
from math import log2
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.search.frontiers import frontier_mask
from indoor_explorers.planners.frontier.burgard import SequentialParameters, SequentialPilot
from indoor_explorers.planners.frontier.group_pilot import ClusterChoices
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters
from indoor_explorers.planners.toolbox.information.view_gain import unclaimed_gains
from indoor_explorers.planners.toolbox.parameters import bounded


@dataclass(frozen=True, kw_only=True)
class FrontierOctree(SequentialParameters, Policy):
    """Fly to the octree block of frontier cells with the most unknown cells in view for each step of the path.

    Source: A. Dai, S. Papatheodorou, N. Funk, D. Tzoumanikas, S. Leutenegger, "Fast frontier-based information-driven
    autonomous exploration with an MAV", ICRA 2020, doi:10.1109/ICRA40945.2020.9196707: the blocks of the map's octree
    group the frontier voxels, so that nothing is clustered, and a view's utility is the entropy that it removes,
    divided by the time to get there. Here an unknown cell has an entropy of one and a known one of none, each block's
    cell nearest to a UAV stands for it, and paths are known ones. There a UAV plans again once it has arrived; here it
    may do so before, at a high switch cost. On one level the octree is a quadtree. Teams take the blocks in turn as in
    :mod:`indoor_explorers.planners.frontier.burgard`.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    block: float = bounded(0.5, least=0, tunable=(0.1, 2.0, "log"))
    """Side of a block in lidar ranges; the nearest power of two in cells is taken, at least one cell."""
    switch_cost: float = 2.0

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return OctreePilot(briefing, self)


class OctreePilot(SequentialPilot):
    """Score pairs of UAV and block by gain and path length."""

    def __init__(self, briefing: Briefing, policy: FrontierOctree) -> None:
        super().__init__(briefing, policy.switch_cost, policy.weight, policy.reach)
        side = max(1.0, policy.block * briefing.lidar_range)
        self._side = 1 << round(log2(side))

    def clusters(self, view: View) -> Clusters:
        """Return the frontier cells by block of a view's belief, block after block."""
        cells = np.flatnonzero(frontier_mask(view.belief, self.paths.rise)).astype(np.int32)
        if len(cells) == 0:
            return Clusters(cells, np.zeros(1, np.int64))
        blocks = self.coordinates(cells) // self._side
        _, numbers, sizes = np.unique(blocks, axis=0, return_inverse=True, return_counts=True)
        order = np.argsort(numbers.ravel(), kind="stable")
        return Clusters(cells[order], np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64))

    def gains(self, view: View, choices: ClusterChoices) -> NDArray[np.float64]:
        """Return the unknown cells in view of each block's cell nearest to any UAV, (K,)."""
        return unclaimed_gains(view.belief, choices.viewpoints(), np.empty((0, 2)), self.lidar).astype(np.float64)

    def score(self, gains: NDArray[np.float64], costs: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the gains for each step (N, K) of pairs of UAV and block; a step is the least that a block costs."""
        return gains / np.maximum(costs, 1.0)
