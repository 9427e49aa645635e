"""Group decisions: each UAV of a group computes the same assignment of UAVs to clusters.

Linked UAVs have the same map and know each other's cells and goals. Each of them computes the goals of all, itself
included, and flies to its own; the results are the same, so no assignment is sent. A silent teammate takes part with
its last received cell until it is forgotten (:mod:`indoor_explorers.planners.toolbox.navigation.teammates`).
"""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Distances
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.view import View
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters, nearest_cells
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.teammates import GroupMember, group_of, message_of, remembered

#: Largest number of clusters considered: those nearest to any UAV of the group.
CLUSTERS = 64
#: Distance, in lidar ranges, within which a frontier cell replaces a goal that is no frontier cell any more.
INHERITANCE = 0.5


class ClusterChoices(NamedTuple):
    """N UAVs of a group, in the order of their numbers, and K clusters, the nearest to any of them."""

    me: int
    """Index of the UAV that decides."""
    clusters: Clusters
    numbers: NDArray[np.int64]
    """(K,) the clusters' numbers among all."""
    cells: NDArray[np.int32]
    """(N, K) the flat cell of each cluster that is nearest to each UAV."""
    steps: Distances
    """(N, K) the steps to it; ``UNREACHABLE`` where no known path leads."""
    held: NDArray[np.bool_]
    """(N, K) whether the UAV is flying to it."""

    def costs(self, switch_cost: float) -> NDArray[np.float64]:
        """Return the steps (N, K), reduced by ``switch_cost`` steps for the cluster that a UAV is flying to."""
        return self.steps - switch_cost * self.held

    def viewpoints(self) -> NDArray[np.int32]:
        """Return the flat cell of each cluster that is nearest to any UAV, (K,)."""
        return np.asarray(self.cells[self.steps.argmin(axis=0), np.arange(self.steps.shape[1])])


class GroupPilot(GoalPilot):
    """Choose again, together with the group, whenever the map has grown."""

    changes_levels: ClassVar[bool] = True
    replan_period: float = 0

    @abstractmethod
    def assigned(self, view: View, choices: ClusterChoices) -> int:
        """Return the index of the cluster that this UAV flies to; it can reach at least one of the K clusters."""

    def choose(self, view: View) -> Cell | None:
        """Return the nearest cell of the cluster assigned to this UAV, or of its nearest cluster if unreachable."""
        self.message = None
        choices = self.choices(view, self.members(view))
        own = choices.steps[choices.me]
        if not (own < UNREACHABLE).any():
            return None
        best = self.assigned(view, choices)
        if own[best] >= UNREACHABLE:
            best = int(own.argmin())
        goal = divmod(int(choices.cells[choices.me, best]), self.paths.width)
        self.message = message_of(goal)
        return goal

    def members(self, view: View) -> list[GroupMember]:
        """Return this UAV and the remembered teammates, by number."""
        own = GroupMember(self.briefing.agent, view.cell, self.goal)
        return group_of(own, remembered(view, self.briefing))

    def choices(self, view: View, members: list[GroupMember]) -> ClusterChoices:
        """Return the UAVs and clusters of this decision."""
        clusters = self.clusters(view)
        near = [nearest_cells(self.steps_from(view, member.cell), clusters) for member in members]
        cells, steps = np.stack([cells for cells, _ in near]), np.stack([steps for _, steps in near])
        me = next(i for i, member in enumerate(members) if member.agent == self.briefing.agent)
        steps[me, self.near_banned(view, cells[me])] = UNREACHABLE
        nearest = steps.min(axis=0)
        numbers = np.argsort(nearest, kind="stable")[:CLUSTERS]
        numbers = numbers[nearest[numbers] < UNREACHABLE]
        held = np.stack([self._held(clusters, member.goal) for member in members])
        return ClusterChoices(me, clusters, numbers, cells[:, numbers], steps[:, numbers], held[:, numbers])

    def _held(self, clusters: Clusters, goal: Cell | None) -> NDArray[np.bool_]:
        """Return the cluster of a goal, or of the frontier cell that replaces it, (clusters,) bool."""
        held = np.zeros(clusters.size, np.bool_)
        if goal is not None and clusters.size:
            away = ((self.coordinates(clusters.cells) - self.coordinates(goal)) ** 2).sum(axis=1)
            place = int(away.argmin())
            near = away[place] <= (INHERITANCE * self.briefing.lidar_range) ** 2
            held[np.searchsorted(clusters.ends, place, side="right") - 1] = near
        return held
