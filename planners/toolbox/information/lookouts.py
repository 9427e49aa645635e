"""Lookouts: viewpoints near a UAV that need not be at a frontier, each for a frontier cluster into which it sees.

On open floors a UAV sees what is behind tables and columns from where it passes, without a flight to each of them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Mask
from indoor_explorers.env.policies.view import View
from indoor_explorers.planners.toolbox.information.candidates import local_candidates
from indoor_explorers.planners.toolbox.information.cluster_places import ClusterPlaces, PlaceCells, log_gains
from indoor_explorers.planners.toolbox.information.view_gain import visible_sets
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot

#: Largest distance of a lookout from the UAV, in lidar ranges.
NEAR = 0.6
#: A viewpoint is left out if a better one sees this share of the unknown cells in its view.
SHARED = 0.5
#: Share of its gain that a lookout has to keep while the UAV flies there.
KEPT = 0.5


class LookoutPilot(GoalPilot):
    """Fly to viewpoints of clusters, or to lookouts, each for as long as it is worth the flight.

    A lookout is no frontier cell, by which other goals are kept, and choices anew at each step would lead to and fro
    between two of them.
    """

    lookouts: Lookouts
    """Finds the lookouts; subclasses set it."""

    def choose_goal(self, view: View) -> None:
        """Choose a goal, and remember whether it is a lookout."""
        super().choose_goal(view)
        self.lookouts.remember(view)

    def is_spent(self, view: View, goal: Cell) -> bool:
        """Tell whether a goal is no frontier cell, and no lookout that is worth the flight."""
        return super().is_spent(view, goal) and not self.lookouts.is_kept(view)

    def wants_replan(self, view: View) -> bool:
        """Tell whether to choose again because the map has grown: on the way to a lookout only if it is not kept."""
        return super().wants_replan(view) and not self.lookouts.is_kept(view)


class Lookouts:
    """Find the lookouts of one UAV.

    Args:
        pilot: The pilot that flies to them.
        places: Finds its viewpoints.
        discount_rate: Discount rate of view gains per lidar range of distance.
        most: Most lookouts at a time, those with the largest discounted gains.

    """

    def __init__(self, pilot: GoalPilot, places: ClusterPlaces, discount_rate: float, most: int) -> None:
        self._pilot, self._places, self._most = pilot, places, most
        self._rate = discount_rate / pilot.briefing.lidar_range
        self._at_frontier = np.empty(0, np.int32)
        self._kept: tuple[Cell, float] | None = None
        """The lookout that the UAV flies to, and its gain when it was chosen."""

    def added_to(self, view: View, found: PlaceCells) -> PlaceCells:
        """Return the L possible viewpoints on frontiers with lookouts behind them."""
        self._at_frontier = found.cells
        if not self._most or not len(found.cells):
            return found
        pilot = self._pilot
        scores = log_gains(self._places.views(view, found.cells)) - self._rate * found.steps
        best = self._places.best_of_each(found.owner, scores, np.zeros(len(scores), np.bool_))
        field = pilot.steps_from(view, view.cell)
        near = local_candidates(view.belief, field[None], pilot.lidar, pilot.steps_in(NEAR), self._rate, self._most)
        near = near[~view.visited.ravel()[near] & ~pilot.near_banned(view, near) & ~np.isin(near, found.cells)]
        if not len(near):
            return found
        sets = visible_sets(view.belief, np.concatenate([found.cells[best], near]), pilot.lidar)
        shared = np.bitwise_count(sets[len(best) :, None] & sets[None, : len(best)]).sum(axis=2)
        chosen = shared.max(axis=1) > 0
        near, owner = near[chosen], found.owner[best[shared[chosen].argmax(axis=1)]]
        return found._replace(
            cells=np.concatenate([found.cells, near]),
            owner=np.concatenate([found.owner, owner]),
            steps=np.concatenate([found.steps, field.ravel()[near]]),
        )

    def distinct(self, view: View, cells: NDArray[np.int32]) -> Mask:
        """Return which of (K,) viewpoints, the best one first, no better one makes superfluous, (K,) bool.

        Without lookouts, these are all.
        """
        kept = np.ones(len(cells), np.bool_)
        if not self._most:
            return kept
        sets = visible_sets(view.belief, cells, self._pilot.lidar)
        sizes = np.bitwise_count(sets).sum(axis=1)
        for k in range(1, len(cells)):
            shared = np.bitwise_count(sets[:k][kept[:k]] & sets[k]).sum(axis=1)
            kept[k] = (shared < SHARED * max(1, sizes[k])).all()
        return kept

    def remember(self, view: View) -> None:
        """Remember the pilot's new goal if it is a lookout, and its gain."""
        goal, self._kept = self._pilot.goal, None
        if self._most and goal is not None and not np.isin(self._pilot.paths.flat([goal]), self._at_frontier).any():
            self._kept = goal, self._gain(view, goal)

    def is_kept(self, view: View) -> bool:
        """Tell whether the pilot's goal is a lookout that is ahead and has most of its gain left."""
        if self._kept is None:
            return False
        cell, gain = self._kept
        return self._pilot.goal == cell != view.cell and self._gain(view, cell) >= KEPT * gain

    def _gain(self, view: View, cell: Cell) -> float:
        return float(self._places.views(view, self._pilot.paths.flat([cell]))[0])
