"""Distance advantage: near frontier clusters that are far from all others are visited first (Ericson et al. 2025)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.frontier.burgard import SequentialPilot
from indoor_explorers.planners.frontier.group_pilot import ClusterChoices
from indoor_explorers.planners.toolbox.parameters import SwitchCostParameters, bounded


@renamed(hold="switch_cost")
@dataclass(frozen=True, kw_only=True)
class FrontierAdvantage(SwitchCostParameters, Policy):
    """Fly to the cluster with the largest advantage: its mean distance from the other clusters, minus the path to it.

    L. Ericson, J. Pedro, P. Jensfelt, "Information gain is not all you need", arXiv:2504.01980, 2025. A cluster that is
    far from all others would cost a detour later; the area behind it plays no role. Distances above ``reach`` count as
    ``reach``. Teams take the clusters in turn as in :mod:`indoor_explorers.planners.frontier.burgard`.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    remoteness: float = bounded(1.0, least=0, tunable=(0.1, 10.0, "log"))
    """Weight of the mean distance from the other clusters against the path length."""
    reach: float = bounded(6.0, least=0, tunable=(1.0, 20.0, "log"))
    """Distance at which another cluster counts as far, in lidar ranges."""
    switch_cost: float = 0.5
    weight: float = bounded(4.0, least=0, tunable=(0.3, 16.0, "log"))
    """A cluster at a place that another UAV has taken counts as this many lidar ranges farther."""
    taken: float = bounded(1.0, least=0, tunable=(0.0, 2.0))
    """Distance up to which a taken cluster adds to the cost of others, in lidar ranges."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return AdvantagePilot(briefing, self)


class AdvantagePilot(SequentialPilot):
    """Score pairs of UAV and cluster by the distance advantage."""

    def __init__(self, briefing: Briefing, policy: FrontierAdvantage) -> None:
        super().__init__(briefing, policy.switch_cost, policy.weight, policy.taken)
        self._remoteness, self._reach = policy.remoteness, policy.reach * briefing.lidar_range

    def gains(self, view: View, choices: ClusterChoices) -> NDArray[np.float64]:
        """Return each cluster's mean distance from the others, weighted, (K,)."""
        between = np.minimum(self.paths.matrix(view.belief, choices.viewpoints()), self._reach)
        return np.asarray(self._remoteness * between.sum(axis=1) / max(1, len(between) - 1))

    def score(self, gains: NDArray[np.float64], costs: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the scores (N, K) of pairs of UAV and cluster."""
        return gains - costs
