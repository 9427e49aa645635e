"""A pilot that flies from node to node of a graph, as a network chooses; without a choice, to the nearest frontier."""

from __future__ import annotations

from abc import abstractmethod
from math import inf

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.teammates import message_of

#: Lidar ranges of flight without growth of the map after which the guard acts.
PATIENCE = 6.0


class NodePilot(GoalPilot):
    """Choose a node, fly to it, and choose again there.

    Where there is no node to choose, and where the guard acts, it flies to the nearest frontier cell.

    Args:
        briefing: Briefing of the UAV.
        patience: Lidar ranges of flight without new cells after which the guard acts; infinite for no guard.

    """

    straight = True

    def __init__(self, briefing: Briefing, *, patience: float) -> None:
        super().__init__(briefing)
        self._patience = inf if patience == inf else self.steps_in(patience)
        self._to_frontier, self._last_growth, self._guarded = False, 0, 0

    @abstractmethod
    def chosen_node(self, view: View) -> Cell | None:
        """Return the cell of the chosen node; None if there is none to choose."""

    def act(self, view: View) -> int:
        """Follow the path to the chosen node, and tell the teammates which."""
        action = super().act(view)
        self.message = message_of(self.goal)
        return action

    def on_map_growth(self, view: View) -> None:
        """Store the step, for the guard."""
        self._last_growth = view.step

    def is_spent(self, view: View, goal: Cell) -> bool:
        """Tell whether the goal is reached; a frontier cell is also spent when it is none any more."""
        return view.cell == goal or (self._to_frontier and super().is_spent(view, goal))

    def choose(self, view: View) -> Cell | None:
        """Return the chosen node, or the nearest frontier cell."""
        self._to_frontier = view.step - self._last_growth > self._patience
        self._guarded += self._to_frontier
        node = None if self._to_frontier else self.chosen_node(view)
        if node is not None:
            return node
        self._to_frontier = True
        return self.nearest_frontier(view)

    def note_on_choice(self) -> str:
        """Return that the guard chose, or that there was no node to choose."""
        return "the nearest frontier cell: the guard acts, or there is no node to choose" if self._to_frontier else ""

    def tally(self) -> dict[str, float]:
        """Return the tally of every such pilot, and the number of goals chosen by the guard."""
        return super().tally() | {"guarded_choices": float(self._guarded)}
