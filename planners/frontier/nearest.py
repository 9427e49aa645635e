"""Nearest frontier: the classic, uncoordinated baseline (Yamauchi 1997)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.frontiers.clusters import nearest_cells
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot


@dataclass(frozen=True, kw_only=True)
class FrontierNearest(Policy):
    """Fly to the frontier cell with the shortest known path, drawn at random among equals; ignore the teammates.

    B. Yamauchi, "A frontier-based approach for autonomous exploration", CIRA 1997,
    doi:10.1109/CIRA.1997.613851.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return NearestPilot(briefing)


class NearestPilot(GoalPilot):
    """Keep the nearest frontier cell as goal until it is no frontier cell any more."""

    changes_levels: ClassVar[bool] = True

    def choose(self, view: View) -> Cell | None:
        """Return the nearest frontier cell."""
        if self.explaining:
            clusters = self.clusters(view)
            cells, steps = nearest_cells(self.steps_from(view, view.cell), clusters)
            self.consider(cells, "steps, negative", -steps, steps=steps)
        return self.nearest_frontier(view)
