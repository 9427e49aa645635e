"""Sequential assignment: a taken frontier lowers the utility of frontiers in its view (Burgard et al. 2005)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.grid.levels import coordinates
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.sensing.lidar import LidarModel, model_of, new_scan, visible_cells
from indoor_explorers.planners.frontier.group_pilot import ClusterChoices, GroupPilot
from indoor_explorers.planners.toolbox.parameters import SwitchCostParameters, bounded


@dataclass(frozen=True, kw_only=True)
class SequentialParameters(SwitchCostParameters):
    """How UAVs keep their clusters, and keep away from those that others have taken in turn."""

    switch_cost: float = 0.5
    weight: float = bounded(4.0, least=0, tunable=(0.3, 16.0, "log"))
    """A cluster at a place that another UAV has taken counts as this many lidar ranges farther (paper: beta)."""
    reach: float = bounded(1.0, least=0, tunable=(0.25, 4.0, "log"))
    """Distance up to which a taken cluster adds to the cost of others, in lidar ranges."""


@renamed(hold="switch_cost")
@dataclass(frozen=True, kw_only=True)
class FrontierBurgard(SequentialParameters, Policy):
    """Assign the best pair of UAV and frontier cluster, lower the utility of clusters in its view, and repeat.

    W. Burgard, M. Moors, C. Stachniss, F. E. Schneider, "Coordinated multi-robot exploration", IEEE T-RO 21(3),
    2005, doi:10.1109/TRO.2004.839232, section III. The score of a pair is the cluster's utility minus the path length.
    All utilities are equal at first; that of a cluster falls with its closeness to a taken cluster, if no known wall
    is between the two.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    switch_cost: float = 1.0

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return SequentialPilot(briefing, self.switch_cost, self.weight, self.reach)


class SequentialPilot(GroupPilot):
    """Take clusters in turn with the other UAVs: the best pair of UAV and cluster first."""

    def __init__(self, briefing: Briefing, switch_cost: float, weight: float, reach: float) -> None:
        super().__init__(briefing)
        self.switch_cost, self.weight, self.reach = (
            value * briefing.lidar_range for value in (switch_cost, weight, reach)
        )
        self._near = self.lidar_of(float(self.reach))

    def score(self, gains: NDArray[np.float64], costs: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the scores (N, K) of pairs of UAV and cluster, from the clusters' gains (K,) and costs in steps."""
        return -costs

    def gains(self, view: View, choices: ClusterChoices) -> NDArray[np.float64]:
        """Return the utility of each cluster before any is taken, (K,)."""
        return np.zeros(len(choices.numbers))

    def assigned(self, view: View, choices: ClusterChoices) -> int:
        """Return the cluster that this UAV gets in its turn."""
        costs, gains, places = choices.costs(self.switch_cost), self.gains(view, choices), choices.viewpoints()
        waiting = np.ones(len(costs), np.bool_)
        while True:
            scores = np.where(choices.steps < UNREACHABLE, self.score(gains, costs), -np.inf)
            scores[~waiting] = -np.inf
            uav, best = np.unravel_index(scores.argmax(), scores.shape)
            if uav == choices.me or scores[uav, best] == -np.inf:
                own, steps = scores[choices.me], choices.steps[choices.me]
                self.consider(
                    choices.cells[choices.me], "gain and cost", own, gain=gains, cost=costs[choices.me], steps=steps
                )
                return int(best)
            waiting[uav] = False
            lost = nearness(view.belief, int(choices.cells[uav, best]), places, self._near, self.paths.rise)
            costs = costs + self.weight * lost


@kernel()
def _in_sight(belief: np.ndarray, origin: int, cells: np.ndarray, lidar: LidarModel) -> np.ndarray:
    scan, seen = new_scan(lidar), np.zeros(belief.size, np.bool_)
    for place in range(visible_cells(belief, origin // belief.shape[1], origin % belief.shape[1], lidar, scan)):
        seen[scan.cells[place]] = True
    return np.asarray(seen[cells])


def nearness(
    belief: Belief, origin: int, cells: NDArray[np.int32], reach: LidarModel | float, rise: int = 0
) -> NDArray[np.float64]:
    """Return the closeness of (K,) flat cells to ``origin``, (K,): 1 there, 0 at ``reach`` cells or behind a wall.

    ``reach`` may be given as the lidar that sees so far.
    """
    lidar, width = model_of(reach), belief.shape[1]
    apart = coordinates(cells, width, rise) - coordinates(np.array(origin), width, rise)
    near = np.maximum(0.0, 1.0 - np.hypot.reduce(apart, axis=1) / max(lidar.range, 1e-9))
    return np.asarray(near * _in_sight(belief, origin, cells, lidar))
