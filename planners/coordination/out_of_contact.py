"""What a UAV leaves to teammates out of contact: places near silent ones, the sectors of those never heard.

Any planner can multiply its gains by these factors. None is 0: a teammate out of contact may have ended, and what was
left to it is explored when nothing else remains.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Distances
from indoor_explorers.env.policies.view import Briefing, Mate, View
from indoor_explorers.planners.coordination.sectors import Sectors
from indoor_explorers.planners.coordination.teammates import remembered, whereabouts

#: The least that one silent teammate leaves of a place.
LEAST = 1e-3
#: Gives the steps (K,) from a cell to each of K places on the current map.
StepsFrom = Callable[[Cell], Distances]


class OutOfContact:
    """What one UAV leaves to the teammates that it is out of contact with, for one episode.

    A silent teammate is taken to work around where it was, or where it said that it goes; one that was never heard, to
    keep to its sector of the map. A forgotten one keeps nothing.

    Args:
        briefing: of the UAV.
        silence: lidar ranges by which a silent teammate must be nearer to a place to leave e^-1 of it.
        sector: how strongly UAVs that never heard of each other keep to their sectors; e^(-2 sector) is left opposite.

    """

    def __init__(self, briefing: Briefing, *, silence: float = 0.3, sector: float = 3.0) -> None:
        self._briefing = briefing
        self._silence = silence * briefing.lidar_range
        self._sector = sector
        self._sectors: Sectors | None = None

    def factors(
        self, view: View, points: NDArray[np.float64], own_steps: Distances, steps_from: StepsFrom
    ) -> NDArray[np.float64]:
        """Return how much of each of K places teammates out of contact leave to this UAV, (K,) in (0, 1].

        ``points`` (K, 2) are the places' rows and columns, ``own_steps`` (K,) how far they are from this UAV. Call it
        first where the UAV starts.
        """
        left = self.left_by_unheard(view, points)
        for mate in remembered(view, self._briefing):
            if mate.age > 0:
                left *= self._left_by_silent(mate, own_steps, steps_from)
        return left

    def left_by_unheard(self, view: View, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how much of K places those never heard leave to this UAV, by their sectors alone, (K,) in (0, 1]."""
        if self._sectors is None:
            self._sectors = Sectors.of(self._briefing, view.cell)
        unheard = self._briefing.team - 1 - len(view.mates)
        if unheard == 0:
            return np.ones(len(points))
        return self._sectors.shares(points, self._briefing.agent, self._sector * unheard / (self._briefing.team - 1))

    def _left_by_silent(self, mate: Mate, own_steps: Distances, steps_from: StepsFrom) -> NDArray[np.float64]:
        ahead = np.maximum(0, own_steps - steps_from(whereabouts(mate)))
        return np.asarray(np.maximum(LEAST, np.exp(-ahead / self._silence)))
