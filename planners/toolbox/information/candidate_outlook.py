"""The outlook of candidates that are no frontier clusters: that of the nearest cluster."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Distances
from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.grid.levels import offset
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters, nearest_cells
from indoor_explorers.planners.toolbox.pockets.estimates import CHANGED, DEFAULT_FILES, EstimateFiles
from indoor_explorers.planners.toolbox.pockets.outlook import ClusterJudge, OutlookParameters


class CandidateOutlook:
    """Compute the probability that one UAV's candidates lead to unknown free cells.

    UAVs of a team that have the same map get the same numbers, so that each can compute the plan of all.
    """

    def __init__(self, briefing: Briefing, files: EstimateFiles = DEFAULT_FILES) -> None:
        self._range, self._rise = float(briefing.lidar_range), briefing.rise
        self._estimator = files.estimator(briefing, CHANGED if briefing.team == 1 else 0)
        self._judge = ClusterJudge(briefing, OutlookParameters())

    def chances(self, view: View, cells: NDArray[np.int32], field: Distances) -> NDArray[np.float64]:
        """Return the probability that each of (K,) flat cells leads to unknown free cells, (K,).

        It is 0 for candidates of deferred clusters, unless there are no others in reach. ``field`` (H, W) are the steps
        from the UAV, or from the nearest one of a group. Without estimates it is 1 for all.
        """
        if self._estimator is None or len(cells) == 0:
            return np.ones(len(cells))
        clusters = frontier_clusters(view.belief, self._range, self._rise)
        if clusters.size == 0:
            return np.ones(len(cells))
        away = nearest_cells(field, clusters)[1]
        known = int(np.count_nonzero(view.belief == FREE))
        outlook = self._judge.outlook(self._estimator.estimate(view.belief, clusters), known, away)
        owner = nearest_clusters(cells, *clusters, view.belief.shape[1], self._rise)
        wanted = ~outlook.deferred[owner]
        if not (wanted & (field.ravel()[cells] < UNREACHABLE)).any():
            wanted[:] = True
        return np.where(wanted, outlook.chances[owner], 0.0)


@kernel()
def nearest_clusters(cells: np.ndarray, members: np.ndarray, ends: np.ndarray, width: int, rise: int = 0) -> np.ndarray:
    """Return the number of the cluster nearest to each of (K,) flat cells in a straight line, (K,).

    ``members`` and ``ends`` are the arrays of :class:`~.clusters.Clusters`, ``rise`` is that of the map.
    """
    owner = np.empty(cells.shape[0], np.int64)
    for place in range(cells.shape[0]):
        row, col = divmod(cells[place], width)
        least = np.inf
        for k in range(ends.shape[0] - 1):
            for cell in members[ends[k] : ends[k + 1]]:
                up, down, right = offset(row, col, cell // width, cell % width, rise)
                away = up * up + down * down + right * right
                if away < least:
                    owner[place], least = k, away
    return owner
