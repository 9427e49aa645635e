"""The work split: how much of each frontier cluster is this UAV's, from what it knows of its teammates.

A planner multiplies the score of every cluster by its share and takes the best, by whatever it scores with. A share
is never 0: when nothing of its own is left, a UAV goes on with the others' clusters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Cell, Distances
from indoor_explorers.env.grid import UNREACHABLE
from indoor_explorers.env.view import Briefing, Mate, Message, View
from indoor_explorers.planners.clusters import Clusters
from indoor_explorers.planners.coordination.places import means, near_goal, sizes, steps_to
from indoor_explorers.planners.coordination.turns import left_over
from indoor_explorers.planners.coordination.unlinked import Unlinked
from indoor_explorers.planners.parameters import at_least
from indoor_explorers.planners.teammates import linked, told_goal

#: A cluster with a cell so near to a goal, in cells, is the one that the goal belongs to.
GOAL_RADIUS = 4.0
#: Gives the (H, W) field of steps from a cell on the current map.
FieldOf = Callable[[Cell], Distances]


def message_of(goal: Cell | None) -> Message:
    """Return what teammates should be told about a goal: its row and column."""
    return (float(goal[0]), float(goal[1])) if goal else None


@dataclass(frozen=True, kw_only=True)
class Sharing:
    """How a team shares the frontier.

    Linked teammates hold the same map and know each other's cells and goals, so each works out the same turns in which
    they choose. What is left to the others is :class:`Unlinked`'s.
    """

    discount: float = 2.5
    """In turns, a cluster is worth the root of its frontier length, times e^-discount for every lidar range to it."""
    hold: float = 1.5
    """Factor on the worth of the cluster that a UAV already flies to."""
    spacing: float = 0.5
    """How far from a cluster that a linked teammate takes a cluster is untouched by that, in lidar ranges."""
    taken: float = 0.01
    """Share left of a cluster that a linked teammate takes."""
    silence: float = 0.3
    """Lidar ranges by which a silent teammate must be nearer to a cluster to leave e^-1 of it."""
    sector: float = 3.0
    """How strongly UAVs that never heard of each other keep to their sectors: e^(-2 sector) is left opposite."""

    def __post_init__(self) -> None:
        at_least(self, 0.0, "discount", "sector")
        at_least(self, 1.0, "hold")
        at_least(self, 1e-3, "spacing", "taken", "silence")


class WorkSplit:
    """One UAV's view of who explores what, for one episode."""

    def __init__(self, briefing: Briefing, sharing: Sharing) -> None:
        self._briefing = briefing
        self._sharing = sharing
        self._unlinked = Unlinked(briefing, silence=sharing.silence, sector=sharing.sector)

    def shares(
        self, view: View, clusters: Clusters, own_steps: Distances, field_of: FieldOf, goal: Cell | None
    ) -> NDArray[np.float64]:
        """Return how much of each of K clusters is this UAV's, (K,) in (0, 1].

        ``own_steps`` (K,) is how far they are from this UAV and ``goal`` the one it has told the teammates. Call it
        first where the UAV starts.
        """
        if self._briefing.team == 1 or clusters.size == 0:
            return np.ones(clusters.size)
        points = means(clusters, view.belief.shape[1])
        share = self._unlinked.factors(view, points, own_steps, lambda cell: steps_to(clusters, field_of(cell)))
        mates = linked(view)
        if mates:
            share *= self._left_by_linked(mates, clusters, points, own_steps, field_of, goal)
        return share

    def _left_by_linked(
        self,
        mates: list[Mate],
        clusters: Clusters,
        points: NDArray[np.float64],
        own_steps: Distances,
        field_of: FieldOf,
        goal: Cell | None,
    ) -> NDArray[np.float64]:
        group = {mate.agent: (steps_to(clusters, field_of(mate.cell)), told_goal(mate)) for mate in mates}
        group[self._briefing.agent] = (own_steps, goal)
        agents = sorted(group)
        worth = np.stack([self._worth(*group[agent], clusters) for agent in agents])
        rules = self._sharing
        radius = rules.spacing * self._briefing.lidar_range
        return left_over(worth, points, agents.index(self._briefing.agent), radius, rules.taken)

    def _worth(self, steps: Distances, goal: Cell | None, clusters: Clusters) -> NDArray[np.float64]:
        ranges = steps / self._briefing.lidar_range
        worth = np.sqrt(sizes(clusters)) * np.exp(-self._sharing.discount * ranges)
        if goal is not None:
            near = near_goal(clusters, goal, GOAL_RADIUS, self._briefing.shape[1])
            worth = np.where(near, self._sharing.hold * worth, worth)
        return np.where(steps < UNREACHABLE, worth, 0.0)
