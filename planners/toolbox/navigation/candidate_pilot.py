"""A pilot that flies to candidates: cells with unknown cells in view, on the frontier or not."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.sensing.lidar import view_gain
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot

#: Distance within which a candidate counts as the current goal: in cells or in lidar ranges, whichever is more.
SAME_CELLS, SAME_RANGES = 1.5, 0.2


class CandidatePilot(GoalPilot):
    """Fly to candidates that a subclass chooses, each at most once.

    ``visited`` holds the candidates that this UAV has reached; there is nothing more to see from them.
    """

    def __init__(self, briefing: Briefing) -> None:
        super().__init__(briefing)
        self.visited: set[Cell] = set()

    def is_spent(self, view: View, goal: Cell) -> bool:
        """Tell whether a goal has no unknown cells in view, or this UAV has been there."""
        if not super().is_spent(view, goal):
            return False
        if view.cell == goal:
            self.visited.add(goal)
        return goal in self.visited or view_gain(view.belief, goal, self.lidar) == 0

    def hysteresis_bonus(self, goal: Cell | None, cells: NDArray[np.int32], bonus: float) -> NDArray[np.float64]:
        """Return the factors on the utilities of (K,) flat cells: ``1 + bonus`` near the UAV's goal, else 1, (K,)."""
        radius = max(SAME_CELLS, SAME_RANGES * self.briefing.lidar_range)
        return self.goal_factors(goal, cells, radius, bonus)
