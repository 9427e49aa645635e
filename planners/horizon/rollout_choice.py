"""Choose the best of a few tours by flying them in sampled rooms."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.search.bitsets import around
from indoor_explorers.env.sensing.lidar import lidar_model
from indoor_explorers.planners.horizon.rollouts import RolloutSetup, steps_to_shares
from indoor_explorers.planners.horizon.room_prior import RoomPrior
from indoor_explorers.planners.toolbox.information.optimistic_views import OptimisticViews

#: Coverages whose steps are in the cost, up to the goal.
SHARES = (0.9, 0.99)
#: Cost of a step to each of these coverages.
COSTS = (3.0, 1.0)
#: Mean improvement over the rooms that another tour must have,
MARGIN = 0.5
#: and the number of standard errors that it must exceed.
SURE = 2.0
#: Fewest rooms for a choice; with fewer the first tour is kept.
FEWEST = 4
#: Rooms after which clearly worse tours are dropped (racing: O. Maron and A. W. Moore, NeurIPS 1993).
RACE_ROOMS = 8


class RolloutSelection:
    """Fly tours in up to ``count`` rooms that a prior samples."""

    def __init__(self, prior: RoomPrior, shape: tuple[int, int], lidar_range: float, goal: float, count: int) -> None:
        self._prior, self._count = prior, count
        self._lens, self._surroundings = lidar_model(float(lidar_range)), around(shape, 2)
        self._shares = np.minimum(SHARES, goal)

    def best(
        self,
        belief: Belief,
        cell: int,
        optimistic: OptimisticViews,
        chances: NDArray[np.float64],
        tours: list[list[int]],
    ) -> int:
        """Return the index of the tour from a flat cell that is significantly better than the first; 0 if none is.

        Tours that are clearly worse after ``RACE_ROOMS`` rooms are not flown in the others. ``chances`` (C,) are the
        probabilities of unknown cells to be free, 0 for cells that need not be seen.
        """
        rooms = self._prior.rooms(belief)[: self._count]
        if len(rooms) < FEWEST:
            return 0
        setup = RolloutSetup(belief, chances, optimistic.views, optimistic.neighbours, self._surroundings)
        excess = self._excess(cell, setup, tours, rooms[:RACE_ROOMS])
        left = np.append(0, np.flatnonzero(excess.mean(axis=1) - _errors(excess) < -MARGIN))
        excess = excess[left]
        if len(left) > 1 and len(rooms) > RACE_ROOMS:
            more = self._excess(cell, setup, [tours[number] for number in left], rooms[RACE_ROOMS:])
            excess = np.hstack([excess, more])
        bound = excess.mean(axis=1) + _errors(excess) + MARGIN
        bound[0] = 0.0
        return int(left[np.argmin(bound)])

    def _excess(self, cell: int, setup: RolloutSetup, tours: list[list[int]], rooms: Belief) -> NDArray[np.float64]:
        """Return the cost of each tour minus that of the first in each room, (T, S)."""
        costs = steps_to_shares(cell, setup, tours, rooms, self._shares, self._lens) @ np.array(COSTS)
        return np.asarray(costs - costs[0])


def _errors(excess: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ``SURE`` standard errors of each tour's mean excess over rooms, (T,)."""
    return np.asarray(SURE * excess.std(axis=1) / excess.shape[1] ** 0.5)
