"""Looking around on the way: paths for a sensor with a limited field of view, whichever planner chooses the goals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot
from indoor_explorers.env.policies.view import Briefing
from indoor_explorers.planners.toolbox.explorers import ExploringWith
from indoor_explorers.planners.toolbox.navigation.camera_moves import CameraMoves
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot


@dataclass(frozen=True, kw_only=True)
class CameraPaths(ExploringWith):
    """Fly to the goals of another policy on the shortest paths on which a camera sees most of the unknown.

    A UAV whose sensor sees a part of its surroundings faces the direction of its last move. Of the moves that bring it
    nearer to its goal it makes the one after which most unknown cells are in view, so it looks around without flying
    farther. Planning the yaw along a given path is from B. Zhou, Y. Zhang, X. Chen, S. Shen, "FUEL: Fast UAV
    exploration using incremental frontier structure and hierarchical planning", IEEE RA-L 6(2), 2021,
    doi:10.1109/LRA.2021.3051563; on a grid a UAV cannot choose its yaw apart from its path. Where the lidar sees all
    around, UAVs fly as the explorer.

    Raises:
        InputError: the sensor's view is limited, and the explorer does not fly to goals, as the planners of frontiers,
            samples and swarms and ``dddqn-places`` do.

    """

    plans_for: ClassVar[str] = ALL_CELLS

    explorer: str = "frontier-predictive"
    """Registry name of the policy that chooses the goals, with its parameters in parentheses if there are any."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV: the explorer's, with another choice of moves."""
        pilot = self.make_explorer().pilot(briefing)
        if briefing.scenario.turns:
            if not isinstance(pilot, GoalPilot):
                raise InputError(
                    f"camera-paths: expected an explorer that flies to goals, such as frontier, rrt or dddqn-places, "
                    f"got {self.explorer!r}; policies with an explorer of their own take camera-paths as explorer"
                )
            pilot.navigator.camera = CameraMoves(briefing)
        return pilot
