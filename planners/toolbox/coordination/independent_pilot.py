"""A pilot that chooses its goal alone, and considers its teammates by factors on the gains."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Distances
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.coordination.out_of_contact import OutOfContact
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.teammates import linked, message_of, sent_goal


class IndependentPilot(GoalPilot):
    """Choose a candidate near this UAV, or else the nearest frontier cell, and send the goal to the teammates."""

    straight: ClassVar[bool] = True
    fallback_figure: ClassVar[str] = "out_of_range"
    """Name, in the tally, of the number of goals that were nearest frontiers because there was no candidate."""

    def __init__(self, briefing: Briefing) -> None:
        super().__init__(briefing)
        self._lidar = float(briefing.lidar_range)
        self._out_of_contact = OutOfContact(briefing)
        self._fallbacks = 0
        self._fell_back = False

    @abstractmethod
    def chosen(self, view: View) -> Cell | None:
        """Return the candidate to fly to; None if none is in range."""

    def choose(self, view: View) -> Cell | None:
        """Return the chosen candidate, or the nearest frontier cell if none is in range."""
        goal = self.chosen(view)
        self._fell_back = goal is None
        if goal is None:
            goal = self.nearest_frontier(view)
            self._fallbacks += goal is not None
        self.message = message_of(goal)
        return goal

    def note_on_choice(self) -> str:
        """Say where the goal is not the rule's."""
        return "the nearest frontier, as the rule found no goal" if self._fell_back and self.goal else ""

    def tally(self) -> dict[str, float]:
        """Return also the number of goals that were nearest frontiers."""
        return {**super().tally(), self.fallback_figure: float(self._fallbacks)}

    def not_dimmed(self, view: View, cells: NDArray[np.int32], dimming: float) -> NDArray[np.float64]:
        """Return the factors on the gains of (K,) flat cells near the goals of linked teammates, (K,).

        A gain loses the share ``dimming`` for each such goal within the lidar range.
        """
        sent = [goal for mate in linked(view) if (goal := sent_goal(mate)) is not None]
        near = sum((self.near_goal(goal, cells, self._lidar).astype(np.int64) for goal in sent), start=np.int64(0))
        return np.broadcast_to((1.0 - dimming) ** near, len(cells))

    def left_by_others(self, view: View, cells: NDArray[np.int32], steps: Distances) -> NDArray[np.float64]:
        """Return the factors on the value of (K,) flat cells, ``steps`` away, for teammates out of contact, (K,)."""
        return self._out_of_contact.at_cells(view, cells, steps, self.steps_from)
