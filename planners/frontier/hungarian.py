"""Hungarian assignment: UAVs and frontier clusters are matched with the least total distance (Wurm et al. 2008)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.frontier.group_pilot import ClusterChoices, GroupPilot
from indoor_explorers.planners.toolbox.parameters import SwitchCostParameters, bounded
from indoor_explorers.planners.toolbox.routing.assignment import matched


@renamed(hold="switch_cost")
@dataclass(frozen=True, kw_only=True)
class FrontierHungarian(SwitchCostParameters, Policy):
    """Fly to the cluster of the assignment of UAVs to frontier clusters with the least total path length.

    K. M. Wurm, C. Stachniss, W. Burgard, "Coordinated multi-robot exploration using a segmentation of the
    environment", IROS 2008, doi:10.1109/IROS.2008.4650734, with clusters in place of its segments. With more UAVs than
    clusters, the UAVs are divided evenly among the clusters.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    switch_cost: float = 1.0
    extra: float = bounded(1.0, least=0, tunable=(0.0, 4.0))
    """Cost of not being the first UAV at a cluster, in lidar ranges."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return HungarianPilot(briefing, self)


class HungarianPilot(GroupPilot):
    """Match all UAVs to clusters and take this UAV's own."""

    def __init__(self, briefing: Briefing, policy: FrontierHungarian) -> None:
        super().__init__(briefing)
        self._policy = policy

    def assigned(self, view: View, choices: ClusterChoices) -> int:
        """Return the cluster matched to this UAV."""
        reach = self.briefing.lidar_range
        costs = choices.costs(self._policy.switch_cost * reach)
        own, steps = costs[choices.me], choices.steps[choices.me]
        self.consider(choices.cells[choices.me], "cost, negative; the group's least sum counts", -own, steps=steps)
        return int(matched(costs, self._policy.extra * reach)[choices.me])
