"""The outlook of candidates that are no frontier clusters: that of the nearest cluster."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Distances
from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters, nearest_cells
from indoor_explorers.planners.toolbox.pockets.estimates import CHANGED, SHIPPED, PocketEstimator
from indoor_explorers.planners.toolbox.pockets.outlook import ClusterJudge, OutlookParameters


class CandidateOutlook:
    """Compute the probability that one UAV's candidates lead to unknown free cells.

    UAVs of a team that have the same map get the same numbers, so that each can compute the plan of all.
    """

    def __init__(self, briefing: Briefing, weights: Path = SHIPPED) -> None:
        self._range, self._levels = float(briefing.lidar_range), briefing.level_count
        self._estimator = PocketEstimator(self._range, changed=CHANGED if briefing.team == 1 else 0, path=weights)
        self._judge = ClusterJudge(briefing, OutlookParameters())

    def chances(self, view: View, cells: NDArray[np.int32], field: Distances) -> NDArray[np.float64]:
        """Return the probability that each of (K,) flat cells leads to unknown free cells, (K,).

        It is 0 for candidates of deferred clusters, unless there are no others in reach. ``field`` (H, W) are the steps
        from the UAV, or from the nearest one of a group. On maps of several levels, which the network does not know, it
        is 1 for all.
        """
        if self._levels > 1:
            return np.ones(len(cells))
        clusters = frontier_clusters(view.belief, self._range)
        if clusters.size == 0 or len(cells) == 0:
            return np.ones(len(cells))
        away = nearest_cells(field, clusters)[1]
        known = int(np.count_nonzero(view.belief == FREE))
        outlook = self._judge.outlook(self._estimator.estimate(view.belief, clusters), known, away)
        owner = nearest_clusters(cells, *clusters, view.belief.shape[1])
        wanted = ~outlook.deferred[owner]
        if not (wanted & (field.ravel()[cells] < UNREACHABLE)).any():
            wanted[:] = True
        return np.where(wanted, outlook.chances[owner], 0.0)


@kernel()
def nearest_clusters(cells: np.ndarray, members: np.ndarray, ends: np.ndarray, width: int) -> np.ndarray:
    """Return the number of the cluster nearest to each of (K,) flat cells in a straight line, (K,).

    ``members`` and ``ends`` are the arrays of :class:`~.clusters.Clusters`.
    """
    owner = np.empty(cells.shape[0], np.int64)
    for place in range(cells.shape[0]):
        row, col = divmod(cells[place], width)
        least = np.inf
        for k in range(ends.shape[0] - 1):
            for cell in members[ends[k] : ends[k + 1]]:
                down, right = cell // width - row, cell % width - col
                away = down * down + right * right
                if away < least:
                    owner[place], least = k, away
    return owner
