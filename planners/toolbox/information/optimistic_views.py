"""Views from, and paths between, all cells of a small map, with unknown cells taken as free and transparent.

Views are sets of cells (:mod:`indoor_explorers.env.search.bitsets`) and are kept up to date as obstacles are found: an
unknown cell that turns out to be free changes nothing. Cell (r, c) has number ``stride`` r + c; the stride is the map's
width for sets of any size and 16 for boards.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import MOVES, OCCUPIED, UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.search.bfs import flood_table
from indoor_explorers.env.search.bitsets import Bits, holds, insert
from indoor_explorers.env.sensing.lidar import LidarModel, Scan, lidar_model, new_scan, visible_cells

#: Steps up to which views are joined; larger distances count as this many steps.
FARTHEST = 40
#: In an array of obstacles, a cell of which nothing is noted yet.
NOT_NOTED = 255


@leaf(entry=False)
def _connect(belief: np.ndarray, stride: int, neighbours: np.ndarray) -> None:
    """List the up to four neighbours of every cell that are no obstacles, (C, 4), -1 for none."""
    height, width = belief.shape
    neighbours[:] = -1
    for r in range(height):
        for c in range(width):
            for k in range(4):
                i, j = r + MOVES[k, 0], c + MOVES[k, 1]
                if 0 <= i < height and 0 <= j < width and belief[r, c] != OCCUPIED and belief[i, j] != OCCUPIED:
                    neighbours[r * stride + c, k] = i * stride + j


@leaf(entry=False)
def _note_obstacles(belief: np.ndarray, reach: int, obstacles: np.ndarray, stale: np.ndarray) -> bool:
    """Bring ``obstacles`` up to date and mark the cells whose views may change; return whether there are any."""
    height, width = belief.shape
    changed = False
    stale[:] = 0
    for r in range(height):
        for c in range(width):
            now = belief[r, c] == OCCUPIED
            if obstacles[r, c] != now:
                obstacles[r, c], changed = now, True
                stale[max(0, r - reach) : r + reach + 1, max(0, c - reach) : c + reach + 1] = 1
    return changed


@leaf()
def update_views(
    belief: np.ndarray,
    stride: int,
    lidar: LidarModel,
    scan: Scan,
    reach: int,
    stale: np.ndarray,
    obstacles: np.ndarray,
    views: np.ndarray,
    neighbours: np.ndarray,
) -> bool:
    """Bring views and neighbours up to date with the obstacles of a (H, W) belief; return whether those have changed.

    ``views`` (C, W) uint64 holds the cells visible from each cell, none from an obstacle, and ``neighbours`` (C, 4)
    int32 its neighbours that are no obstacles, -1 for none. ``obstacles`` (H, W) uint8 keeps the obstacles noted
    before, at first ``NOT_NOTED``; ``stale``, as large at least, is scratch. ``reach`` is more than the lidar's range
    in cells.
    """
    if not _note_obstacles(belief, reach, obstacles, stale):
        return False
    height, width = belief.shape
    for r in range(height):
        for c in range(width):
            if stale[r, c]:
                view = views[r * stride + c]
                view[:] = 0
                if belief[r, c] != OCCUPIED:
                    for k in range(visible_cells(belief, r, c, lidar, scan)):
                        row, col = divmod(scan.cells[k], width)
                        insert(view, row * stride + col)
    _connect(belief, stride, neighbours)
    return True


@leaf()
def attainable(
    start: int, views: np.ndarray, neighbours: np.ndarray, queue: np.ndarray, steps: np.ndarray, out: np.ndarray
) -> None:
    """Write into ``out`` (W,) the cells visible from any cell that is reachable from ``start``.

    ``queue`` and ``steps``, (C,) int32, are scratch.
    """
    out[:] = 0
    steps[:] = UNREACHABLE
    steps[start], queue[0] = 0, start
    for place in range(flood_table(neighbours, 1, queue, steps)):
        for w in range(out.shape[0]):
            out[w] |= views[queue[place], w]


@kernel()
def _join(views: np.ndarray, neighbours: np.ndarray, within: np.ndarray) -> None:
    """Fill ``within`` (D, C, W): the cells that a UAV can have seen d steps from a cell."""
    within[0] = views
    for d in range(1, within.shape[0]):
        for cell in range(views.shape[0]):
            for w in range(views.shape[1]):
                word = within[d - 1, cell, w]
                for k in range(4):
                    if neighbours[cell, k] >= 0:
                        word |= within[d - 1, neighbours[cell, k], w]
                within[d, cell, w] = word


@kernel()
def _first_steps(within: np.ndarray, cell: int) -> np.ndarray:
    steps = np.full(within.shape[1], within.shape[0], np.int32)
    for d in range(within.shape[0] - 1, -1, -1):
        for seen in range(within.shape[1]):
            if holds(within[d, cell], seen):
                steps[seen] = d
    return steps


class OptimisticViews:
    """The views on one pilot's map of C = H*W cells, in sets of W words, if all unknown cells were free."""

    def __init__(self, shape: tuple[int, int], lidar_range: float) -> None:
        cells, words = shape[0] * shape[1], -(-shape[0] * shape[1] // 64)
        self.views: NDArray[np.uint64] = np.zeros((cells, words), np.uint64)
        """(C, W) the cells visible from each cell."""
        self.neighbours = np.full((cells, 4), -1, np.int32)
        """(C, 4) neighbours that may be free, -1 for none."""
        self.views_within: NDArray[np.uint64] = np.zeros((min(sum(shape), FARTHEST), cells, words), np.uint64)
        """(D, C, W) the cells that can have been seen d steps from each cell."""
        self._lens = lidar_model(float(lidar_range))
        self._scan = new_scan(self._lens)
        self._reach, self._stride = int(lidar_range) + 1, shape[1]
        self._stale, self._obstacles = np.zeros(shape, np.uint8), np.full(shape, NOT_NOTED, np.uint8)
        self._queue, self._steps = np.empty(cells, np.int32), np.empty(cells, np.int32)

    def update(self, belief: Belief) -> bool:
        """Update the views for a (H, W) belief; return whether it has new obstacles, or is the first."""
        changed = update_views(
            belief,
            self._stride,
            self._lens,
            self._scan,
            self._reach,
            self._stale,
            self._obstacles,
            self.views,
            self.neighbours,
        )
        if changed:
            _join(self.views, self.neighbours, self.views_within)
        return bool(changed)

    def attainable(self, cell: int) -> Bits:
        """Return the cells that a UAV in a flat cell can still see, however long it takes, (W,)."""
        out = np.empty(self.views.shape[1], np.uint64)
        attainable(cell, self.views, self.neighbours, self._queue, self._steps, out)
        return out

    def first_steps(self, cell: int) -> NDArray[np.int32]:
        """Return the fewest steps from a flat cell after which each cell can be seen, (C,)."""
        return np.asarray(_first_steps(self.views_within, cell))
