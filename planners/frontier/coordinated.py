"""A team that shares the frontier: discounted view gain times the share of the work split."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Cell
from indoor_explorers.env.grid import UNREACHABLE
from indoor_explorers.env.policy import Pilot, Policy
from indoor_explorers.env.view import Briefing, View
from indoor_explorers.planners.clusters import frontier_clusters, nearest_cells
from indoor_explorers.planners.coordination.split import GOAL_RADIUS, Sharing, WorkSplit, message_of
from indoor_explorers.planners.gains import unclaimed_gains
from indoor_explorers.planners.goals import GoalPilot
from indoor_explorers.planners.parameters import at_least
from indoor_explorers.planners.teammates import NO_CLAIMS


@dataclass(frozen=True, kw_only=True)
class FrontierCoordinated(Policy):
    """Fly to the frontier cluster with the highest sqrt(g) e^(-discount d / R) times its share of the work.

    g: the unknown cells visible from the cluster's nearest cell; d: the steps to it; R: the lidar range. How the team
    shares the clusters is :class:`Sharing`'s; goals are told to the teammates and chosen again when the map grows. The
    discounted gain is that of H. H. Gonzalez-Banos, J.-C. Latombe, "Navigation strategies for exploring indoor
    environments", IJRR 2002, doi:10.1177/0278364902021010834, with the root of the gain.
    """

    discount: float = 2.5
    """How fast a cluster loses worth with distance, per lidar range."""
    hold: float = 1.2
    """Factor on the score of clusters near the present goal."""
    sharing: Sharing = field(default_factory=Sharing)
    """How the team shares the clusters."""

    def __post_init__(self) -> None:
        at_least(self, 0.0, "discount")
        at_least(self, 1.0, "hold")

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the mind of one UAV."""
        return CoordinatedPilot(briefing, self)


class CoordinatedPilot(GoalPilot):
    """Choose again whenever the map has grown."""

    def __init__(self, briefing: Briefing, policy: FrontierCoordinated) -> None:
        super().__init__(briefing)
        self._policy = policy
        self._split = WorkSplit(briefing, policy.sharing)

    def reconsider(self, view: View) -> bool:
        """Tell whether the map has grown since the last step."""
        return self.map_grew

    def choose(self, view: View) -> Cell | None:
        """Return the nearest cell of the best cluster."""
        clusters = frontier_clusters(view.belief, self.briefing.lidar_range)
        cells, own = nearest_cells(self.paths.field(view.belief, view.cell), clusters)
        score = self._scores(view, cells, own)
        score *= self._split.shares(view, clusters, own, lambda cell: self.paths.field(view.belief, cell), self.goal)
        score[self.shunned(view, cells) | (own >= UNREACHABLE)] = -1.0
        best = int(score.argmax()) if len(score) else -1
        goal = divmod(int(cells[best]), self.paths.width) if best >= 0 and score[best] >= 0.0 else None
        self.message = message_of(goal)
        return goal

    def _scores(self, view: View, cells: NDArray[np.int32], own: NDArray[np.int32]) -> NDArray[np.float64]:
        """Return what (K,) flat cells at (K,) steps are worth, (K,) float64."""
        reach = self.briefing.lidar_range
        gains = np.maximum(1, unclaimed_gains(view.belief, cells, NO_CLAIMS, reach))
        score = np.sqrt(gains) * np.exp(-self._policy.discount / reach * own)
        if self.goal is not None:
            rows, cols = np.divmod(cells, self.paths.width)
            near = (rows - self.goal[0]) ** 2 + (cols - self.goal[1]) ** 2 <= GOAL_RADIUS**2
            score[near] *= self._policy.hold
        return np.asarray(score)
