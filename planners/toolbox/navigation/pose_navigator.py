"""Navigation to poses: the last turns at a goal, and turns on the way."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import TURN, Action
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.information.pose_views import Camera
from indoor_explorers.planners.toolbox.navigation.navigator import Navigator
from indoor_explorers.planners.toolbox.navigation.poses import ANY
from indoor_explorers.planners.toolbox.navigation.view_paths import WayParameters, view_path


class Pose(NamedTuple):
    """A cell, and the heading there."""

    cell: Cell
    heading: int
    """The action whose direction the UAV faces; ``ANY`` if it is all the same."""


class PoseNavigator(Navigator):
    """Fly to poses by ways that see much.

    Args:
        briefing: Briefing of the UAV.
        camera: Its lidar.
        values: Returns the values of unknown cells in a view, (H*W,).
        parameters: What a way is worth.

    """

    def __init__(
        self,
        briefing: Briefing,
        camera: Camera,
        values: Callable[[View], NDArray[np.float64]],
        parameters: WayParameters,
    ) -> None:
        super().__init__(briefing)
        self._camera, self._values, self._parameters = camera, values, parameters
        self.aim: Pose | None = None
        """The pose to fly to: its heading is that of the goal while the goal is in its cell."""

    @property
    def pose(self) -> Pose | None:
        """The pose of the current goal; None without a goal."""
        if self.goal is None:
            return None
        return self.aim if self.aim and self.aim.cell == self.goal else Pose(self.goal, ANY)

    def command(self, view: View, following: Cell) -> int:
        """Return the action that leads to an adjacent cell, or the turn that is due in the own one."""
        if following == view.cell and self._turn_is_due(view):
            self.deadlock.expect(view.cell, Action.STAY)
            return TURN
        return super().command(view, following)

    def _turn_is_due(self, view: View) -> bool:
        if self.deadlock.retreating or self.goal is None:
            return False
        if self._at + 1 < len(self._path):
            return self._path[self._at + 1] == view.cell
        return self.pose is not None and self.pose.cell == view.cell and self.pose.heading not in (ANY, view.heading)

    def _shortest(self, view: View, goal: Cell) -> list[Cell]:
        heading = self.aim.heading if self.aim and self.aim.cell == goal else ANY
        start, end = (view.cell, view.heading or 0), (goal, heading)
        return view_path(view.belief, self._values(view), self._camera, start, end, self._parameters)
