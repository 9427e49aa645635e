"""Navigation by ways that see much, for UAVs with a limited field of view."""

from __future__ import annotations

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import TURN, Action
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.information.camera import camera, unknown_weights
from indoor_explorers.planners.toolbox.information.candidates import UnknownWeight
from indoor_explorers.planners.toolbox.navigation.navigator import Navigator
from indoor_explorers.planners.toolbox.navigation.view_paths import WayParameters, view_path


class ViewNavigator(Navigator):
    """Fly to goals by ways that see much (:mod:`~.view_paths`); a path's cell that follows itself is a turn.

    Args:
        briefing: Briefing of the UAV.
        weight: Weight of unknown cells in view.
        ways: What a way is worth.

    """

    def __init__(self, briefing: Briefing, weight: UnknownWeight, ways: WayParameters) -> None:
        super().__init__(briefing)
        self._camera = camera(briefing.lidar_range, briefing.scenario.lidar.field_of_view)
        self._weight, self._ways = weight, ways

    def command(self, view: View, following: Cell) -> int:
        """Return the action that leads to an adjacent cell, or the turn that the path has in the own one."""
        if following == view.cell and not self.deadlock.retreating and self.path[1:2] == [following]:
            self.deadlock.expect(view.cell, Action.STAY)
            return TURN
        return super().command(view, following)

    def _shortest(self, view: View, goal: Cell) -> list[Cell]:
        value = unknown_weights(view.belief, self._weight)
        return view_path(view.belief, value, self._camera, (view.cell, view.heading or 0), goal, self._ways)
