"""A pilot that flies to lookouts: places with something unknown in view, be they on the frontier or not."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.sensing.lidar import view_gain
from indoor_explorers.planners.navigation.goal_pilot import GoalPilot

#: Places this near to a goal are taken for the same, in cells or in lidar ranges, whichever is more.
SAME_CELLS, SAME_RANGES = 1.5, 0.2


class LookoutPilot(GoalPilot):
    """Fly to lookouts that a subclass chooses, each at most once.

    ``visited`` holds the cells in which this UAV has ended a flight: it has seen what can be seen from there.
    """

    def __init__(self, briefing: Briefing) -> None:
        super().__init__(briefing)
        self.visited: set[Cell] = set()

    def spent(self, view: View, goal: Cell) -> bool:
        """Tell whether nothing unknown is in view of a goal, or this UAV has been there and seen what it could."""
        if not super().spent(view, goal):
            return False
        if view.cell == goal:
            self.visited.add(goal)
        return goal in self.visited or view_gain(view.belief, goal, float(self.briefing.lidar_range)) == 0

    def favour(self, goal: Cell | None, cells: NDArray[np.int32], hold: float) -> NDArray[np.float64]:
        """Return what (K,) flat cells count for a UAV on its way to a goal, (K,): ``1 + hold`` near it, 1 elsewhere."""
        if goal is None:
            return np.ones(len(cells))
        rows, cols = np.divmod(cells, self.paths.width)
        away = np.hypot(rows - goal[0], cols - goal[1])
        return np.where(away <= max(SAME_CELLS, SAME_RANGES * self.briefing.lidar_range), 1.0 + hold, 1.0)
