"""The chance of an unknown cell to be free, learned from what unknown cells turned out to be before."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.search.bitsets import AROUND

#: How many observations the first guess counts as.
CONFIDENCE = 20.0
#: The first guess: the chance to be free with 0, 1, ... 8 known obstacles around (a cell of thin walls or of blocks).
FIRST_GUESS = (1.0, 0.6, 0.5, 0.35, 0.3, 0.25, 0.2, 0.15, 0.0)


class Prior(Protocol):
    """Tell how likely cells are free."""

    def free_chances(self, belief: Belief) -> NDArray[np.float64]:
        """Return the chance of each cell of a (H, W) belief to be free, (H*W,)."""


def obstacles_around(obstacles: Mask) -> NDArray[np.int64]:
    """Count the obstacles among the eight cells around each one, (H, W)."""
    height, width = obstacles.shape
    wide = np.pad(obstacles.astype(np.int64), 1)
    shifted = [wide[1 + r : 1 + r + height, 1 + c : 1 + c + width] for r, c in AROUND]
    return np.asarray(np.sum(shifted, axis=0))


class LearnedPrior:
    """Reckon with what has been revealed so far: how often cells with k known obstacles around them were free.

    Every cell that a scan reveals is counted by the obstacles that were known around it before that scan, on top of a
    first guess. It works for any source of maps. A cell with nothing known around it is taken to be free.
    """

    def __init__(self) -> None:
        self._seen = np.full(9, CONFIDENCE)
        self._free = CONFIDENCE * np.array(FIRST_GUESS)
        self._before: tuple[Mask, NDArray[np.int64]] | None = None

    def free_chances(self, belief: Belief) -> NDArray[np.float64]:
        """Return the chance of each cell of a (H, W) belief to be free, (H*W,), and learn from what is new in it."""
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
    """Take every cell to be free."""

    def free_chances(self, belief: Belief) -> NDArray[np.float64]:
        """Return ones, (H*W,)."""
        return np.ones(belief.size)
