"""The probability that an unknown cell is free, learned during the flight from revealed cells."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.search.bitsets import AROUND

#: Number of observations that the initial estimate is equivalent to.
CONFIDENCE = 20.0
#: The initial estimate: probability to be free with 0, 1, ... 8 known obstacles around, for thin walls or blocks.
FIRST_GUESS = (1.0, 0.6, 0.5, 0.35, 0.3, 0.25, 0.2, 0.15, 0.0)


class Prior(Protocol):
    """Estimate the probability that cells are free."""

    def free_chances(self, belief: Belief) -> NDArray[np.float64]:
        """Return the probability that each cell of a (H, W) belief is free, (H*W,)."""


def obstacles_around(obstacles: Mask) -> NDArray[np.int64]:
    """Count the obstacles among the eight cells around each one, (H, W)."""
    height, width = obstacles.shape
    wide = np.pad(obstacles.astype(np.int64), 1)
    shifted = [wide[1 + r : 1 + r + height, 1 + c : 1 + c + width] for r, c in AROUND]
    return np.asarray(np.sum(shifted, axis=0))


class LearnedPrior:
    """Estimate from the revealed cells how often cells with k known obstacles around them are free.

    Every cell that a scan reveals is counted by the obstacles that were known around it before that scan, in addition
    to an initial estimate. This works for maps of any source. A cell without known cells around it counts as free.
    """

    def __init__(self) -> None:
        self._seen = np.full(9, CONFIDENCE)
        self._free = CONFIDENCE * np.array(FIRST_GUESS)
        self._before: tuple[Mask, NDArray[np.int64]] | None = None

    def free_chances(self, belief: Belief) -> NDArray[np.float64]:
        """Learn from newly known cells of a (H, W) belief; return the probability of each cell to be free, (H*W,)."""
        if self._before is not None:
            unknown, around = self._before
            revealed = unknown & (belief != UNKNOWN)
            self._seen += np.bincount(around[revealed], minlength=9)
            self._free += np.bincount(around[revealed & (belief == FREE)], minlength=9)
        around = obstacles_around(belief == OCCUPIED)
        self._before = belief == UNKNOWN, around
        chances = self._free / self._seen
        chances[0] = 1.0
        return np.asarray(chances[around].ravel())


class OpenPrior:
    """Assume that every cell is free."""

    def free_chances(self, belief: Belief) -> NDArray[np.float64]:
        """Return ones, (H*W,)."""
        return np.ones(belief.size)
