"""MinPos: each UAV takes the frontier cluster for which its rank by distance is best (Bautin et al. 2012)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.frontiers.clusters import nearest_cells
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.teammates import ranks, remembered


@dataclass(frozen=True, kw_only=True)
class FrontierMinPos(Policy):
    """Fly to the frontier cluster that the fewest teammates are closer to; among equals to the nearest.

    It needs no messages, only the merged map and the teammates' last received cells.

    A. Bautin, O. Simonin, F. Charpillet, "MinPos: a novel frontier allocation algorithm for multi-robot
    exploration", ICIRA 2012, doi:10.1007/978-3-642-33515-0_49.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return MinPosPilot(briefing)


class MinPosPilot(GoalPilot):
    """Rank the UAVs for every cluster, and take the cluster with this UAV's best rank."""

    changes_levels: ClassVar[bool] = True

    def choose(self, view: View) -> Cell | None:
        """Return the nearest cell of the cluster with the lowest (rank, distance)."""
        clusters = self.clusters(view)
        field = self.steps_from(view, view.cell)
        cells, own = nearest_cells(field, clusters)
        own[self.near_banned(view, cells)] = UNREACHABLE
        if not (own < UNREACHABLE).any():
            return None
        mates = remembered(view, self.briefing)
        others = [nearest_cells(self.steps_from(view, mate.cell), clusters)[1] for mate in mates]
        rank = ranks(own, others, [mate.agent < self.briefing.agent for mate in mates])
        order = np.lexsort((own, rank))
        self.consider(
            cells[order],
            "rank by distance, negative; then the steps",
            -rank[order],
            rank=rank[order],
            steps=own[order],
        )
        best = next(k for k in order.tolist() if own[k] < UNREACHABLE)
        return divmod(int(cells[best]), self.paths.width)
