"""Which of a few tours is best, judged by flying them in sampled rooms."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Belief
from indoor_explorers.env.lidar import optics
from indoor_explorers.planners.horizon.cellsets import around
from indoor_explorers.planners.horizon.rollouts import Stage, steps_to_shares
from indoor_explorers.planners.horizon.rooms import RoomPrior
from indoor_explorers.planners.horizon.sights import Sights

#: The shares of the cells whose steps count, cut off at the goal.
SHARES = (0.9, 0.99)
#: What a step to each of them costs. The first is had anyway soon; weighed less, it suffers for the second.
COSTS = (3.0, 1.0)
#: Another tour has to be better by so much at the least, on average over the rooms.
MARGIN = 0.5
#: And by so many standard errors.
SURE = 2.0
#: Fewer rooms tell nothing.
FEWEST = 4


class Rehearsal:
    """Fly tours in up to ``count`` rooms that a prior samples."""

    def __init__(self, prior: RoomPrior, shape: tuple[int, int], lidar_range: float, goal: float, count: int) -> None:
        self._prior, self._count = prior, count
        self._lens, self._surroundings = optics(float(lidar_range)), around(shape, 2)
        self._shares = np.minimum(SHARES, goal)

    def best(
        self, belief: Belief, cell: int, sights: Sights, chances: NDArray[np.float64], tours: list[list[int]]
    ) -> int:
        """Return the number of the tour that is best for sure, of those from a flat cell; 0 when none is.

        ``chances`` (C,) are those of unknown cells to be free, 0 where nothing is to be seen.
        """
        rooms = self._prior.rooms(belief)[: self._count]
        if len(rooms) < FEWEST:
            return 0
        stage = Stage(belief, chances, sights.views, sights.passages, self._surroundings)
        costs = steps_to_shares(cell, stage, tours, rooms, self._shares, self._lens) @ np.array(COSTS)
        excess = costs - costs[0]
        bound = excess.mean(axis=1) + SURE * excess.std(axis=1) / len(rooms) ** 0.5 + MARGIN
        bound[0] = 0.0
        return int(np.argmin(bound))
