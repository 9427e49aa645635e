"""What can be seen from every cell of a small map and in how many steps, kept up to date as obstacles are found."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Mask
from indoor_explorers.env.grid.cells import MOVES, OCCUPIED
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.search.bitsets import Bits, holds, insert
from indoor_explorers.env.sensing.lidar import Optics, new_scan, optics, visible_cells

#: Steps for which sights are spread at most; what takes longer counts as this far.
FARTHEST = 40


@kernel()
def _look(belief: np.ndarray, stale: np.ndarray, lens: Optics, views: np.ndarray) -> None:
    """Renew the rows of ``views`` (C, W) of the stale cells; unknown cells are transparent, obstacles see nothing."""
    width = belief.shape[1]
    scan = new_scan(lens)
    for cell in np.flatnonzero(stale):
        views[cell] = 0
        if belief[cell // width, cell % width] != OCCUPIED:
            for k in range(visible_cells(belief, cell // width, cell % width, lens, scan)):
                insert(views[cell], scan.cells[k])


@kernel()
def _connect(belief: np.ndarray, passages: np.ndarray) -> None:
    """List the up to four neighbours of every cell that are not known to be obstacles, (C, 4), -1 for none."""
    height, width = belief.shape
    passages[:] = -1
    for cell in range(height * width):
        row, col = divmod(cell, width)
        for k in range(4):
            r, c = row + MOVES[k, 0], col + MOVES[k, 1]
            if 0 <= r < height and 0 <= c < width and belief[row, col] != OCCUPIED and belief[r, c] != OCCUPIED:
                passages[cell, k] = r * width + c


@kernel()
def _spread(views: np.ndarray, passages: np.ndarray, soon: np.ndarray) -> None:
    """Fill ``soon`` (D, C, W): what a UAV can have seen d steps from a cell, were all unknown cells free."""
    soon[0] = views
    for d in range(1, soon.shape[0]):
        for cell in range(views.shape[0]):
            for w in range(views.shape[1]):
                word = soon[d - 1, cell, w]
                for k in range(4):
                    if passages[cell, k] >= 0:
                        word |= soon[d - 1, passages[cell, k], w]
                soon[d, cell, w] = word


@kernel()
def _first_steps(soon: np.ndarray, cell: int) -> np.ndarray:
    steps = np.full(soon.shape[1], soon.shape[0], np.int32)
    for d in range(soon.shape[0] - 1, -1, -1):
        for seen in range(soon.shape[1]):
            if holds(soon[d, cell], seen):
                steps[seen] = d
    return steps


class Sights:
    """The sights of one pilot's map of C = H*W cells in W words.

    Only what obstacles change is worked out again: an unknown cell that turns out to be free changes nothing.
    """

    def __init__(self, shape: tuple[int, int], lidar_range: float) -> None:
        cells, words = shape[0] * shape[1], -(-shape[0] * shape[1] // 64)
        self.views: NDArray[np.uint64] = np.zeros((cells, words), np.uint64)
        """(C, W) what is visible from each cell."""
        self.passages = np.full((cells, 4), -1, np.int32)
        """(C, 4) neighbours that may be free, -1 for none."""
        self.soon: NDArray[np.uint64] = np.zeros((min(sum(shape), FARTHEST), cells, words), np.uint64)
        """(D, C, W) what can have been seen d steps from each cell."""
        self._lens = optics(float(lidar_range))
        self._reach = int(lidar_range) + 1
        self._obstacles: Mask | None = None

    def update(self, belief: Belief) -> bool:
        """Take note of a (H, W) belief; return whether it showed new obstacles, or is the first."""
        obstacles = belief == OCCUPIED
        if self._obstacles is not None and np.array_equal(obstacles, self._obstacles):
            return False
        _look(belief, self._stale(obstacles).ravel(), self._lens, self.views)
        _connect(belief, self.passages)
        _spread(self.views, self.passages, self.soon)
        self._obstacles = obstacles
        return True

    def attainable(self, cell: int) -> Bits:
        """Return what can still be seen by a UAV in a flat cell, however long it takes, (W,)."""
        reached, fresh = {cell}, [cell]
        while fresh:
            fresh = [n for n in set(self.passages[fresh].ravel().tolist()) if n >= 0 and n not in reached]
            reached.update(fresh)
        return np.asarray(np.bitwise_or.reduce(self.views[sorted(reached)], axis=0))

    def first_steps(self, cell: int) -> NDArray[np.int32]:
        """Return after how many steps from a flat cell each cell can be seen at the earliest, (C,)."""
        return np.asarray(_first_steps(self.soon, cell))

    def _stale(self, obstacles: Mask) -> Mask:
        """Return the cells whose sight may have changed, (H, W)."""
        stale = np.full(obstacles.shape, self._obstacles is None)
        if self._obstacles is not None:
            for row, col in np.argwhere(obstacles & ~self._obstacles).tolist():
                rows = slice(max(0, row - self._reach), row + self._reach + 1)
                stale[rows, max(0, col - self._reach) : col + self._reach + 1] = True
        return stale
