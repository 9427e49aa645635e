"""Frontier clusters in an order of low mean waiting time, and ways to them that see much with a narrow view."""

from __future__ import annotations

from dataclasses import dataclass, replace

from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing
from indoor_explorers.env.sensing.field_of_view import ALL_AROUND
from indoor_explorers.planners.frontier.latency import FrontierLatency, LatencyPilot
from indoor_explorers.planners.toolbox.information.candidates import UnknownWeight
from indoor_explorers.planners.toolbox.navigation.view_navigator import ViewNavigator
from indoor_explorers.planners.toolbox.navigation.view_paths import WayParameters
from indoor_explorers.planners.toolbox.parameters import bounded


@renamed()
@dataclass(frozen=True, kw_only=True)
class FrontierHeading(FrontierLatency):
    """Order clusters as ``frontier-latency`` does, and choose among the ways to the first by what they show.

    For lidars with a limited field of view, which faces the direction of the last move. Of all shortest ways to the
    goal, a UAV flies the one whose sectors show the most unknown cells, each counted once: the yaw planning of B. Zhou
    et al., FUEL, RA-L 2021, doi:10.1109/LRA.2021.3051563, where moves decide the yaw, with gains by sector as in A.
    Bircher et al., ICRA 2016, doi:10.1109/ICRA.2016.7487281. With ``slack`` ways may be longer and turn in place. Where
    the lidar sees all around, the policy is ``frontier-latency``.
    """

    narrow_isolation: float = bounded(0.0, least=0)
    """``isolation`` with a limited field of view, which leaves isolated cells beside every flight."""
    slack: int = bounded(0, least=0)
    """Most steps that a way may be longer than a shortest one."""
    price: float = bounded(4.0, least=0)
    """Weight of unknown cells that each of these steps has to show."""
    way_decay_length: float = bounded(0.5, least=0.01)
    """Depth inside unknown space over which the weight of a cell falls to 1 / e on the way, in lidar ranges."""
    reach: float = bounded(2.0, least=0)
    """Length of the part of a way that is chosen by what it shows, in lidar ranges."""
    width: int = bounded(16, least=1)
    """Ways kept at each step of the search."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        if briefing.scenario.lidar.field_of_view >= ALL_AROUND:
            return LatencyPilot(briefing, self)
        return HeadingPilot(briefing, replace(self, isolation=self.narrow_isolation))


class HeadingPilot(LatencyPilot):
    """Fly to the first cluster by a way that sees much."""

    def __init__(self, briefing: Briefing, policy: FrontierHeading) -> None:
        self._heading = policy
        super().__init__(briefing, policy)

    def new_navigator(self, briefing: Briefing) -> ViewNavigator:
        """Return the navigator of an episode."""
        policy, reach = self._heading, briefing.lidar_range
        ways = WayParameters(policy.price, policy.slack, max(1, round(policy.reach * reach)), policy.width)
        return ViewNavigator(briefing, UnknownWeight(0.0, policy.way_decay_length * reach), ways)
