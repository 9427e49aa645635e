"""Shortest paths through known free cells: breadth-first searches that stop early and reuse their buffers.

Cells are flat indices (row * width + column) inside compiled code and (row, column) outside. ``barred``
lists flat cells that a search must not enter, such as the cell of a teammate in the way; ``avoid`` lists
flat cells near which frontier cells are ignored.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Cell, Distances
from indoor_explorers.env.grid.cells import OCCUPIED, UNKNOWN, UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.grid.levels import offset
from indoor_explorers.env.grid.randomness import draw
from indoor_explorers.env.policies.view import View
from indoor_explorers.env.search.bfs import distances_from
from indoor_explorers.env.search.frontiers import on_frontier
from indoor_explorers.planners.toolbox.navigation.shortest_paths import (
    Cells,
    SearchBuffers,
    begin,
    expand,
    fill_distances,
    path_to,
    search_to,
    search_within,
)

#: Chebyshev distance in cells within which frontier cells near an avoided cell are ignored, too.
AVOID_RADIUS = 2


@leaf(entry=False)
def _is_near(cell: int, width: int, avoid: np.ndarray, rise: int) -> bool:
    row, col = divmod(cell, width)
    for k in range(avoid.shape[0]):
        levels, rows, cols = offset(row, col, avoid[k] // width, avoid[k] % width, rise)
        if max(abs(levels), abs(rows), abs(cols)) <= AVOID_RADIUS:
            return True
    return False


@kernel()
def near_any(cells: np.ndarray, avoid: np.ndarray, width: int, rise: int = 0) -> np.ndarray:
    """Return which of (K,) flat cells are within ``AVOID_RADIUS`` of one of ``avoid``, (K,) bool."""
    near = np.zeros(cells.shape[0], np.bool_)
    for k in range(cells.shape[0]):
        near[k] = _is_near(cells[k], width, avoid, rise)
    return near


@leaf()
def search_frontier(
    belief: np.ndarray,
    start: int,
    avoid: np.ndarray,
    ties: np.uint64,
    buffers: SearchBuffers,
    number: int,
    rise: int = 0,
) -> int:
    """Return the flat frontier cell of a (H, W) belief nearest to ``start``, -1 for none.

    ``avoid`` (K,) are flat cells; frontier cells near them do not count. ``ties``, 64 random bits,
    decides among equals.
    """
    cells, width = belief.reshape(belief.size), belief.shape[1]
    begin(start, buffers, number)
    head, tail, layer_end = 0, 1, 1
    best, best_rank = -1, np.uint64(0)
    while head < tail:
        cell = buffers.queue[head]
        if head == layer_end:
            if best >= 0:
                break
            layer_end = tail
        if on_frontier(belief, cell, rise) and not _is_near(cell, width, avoid, rise):
            rank = draw(ties, np.uint64(cell))
            if best < 0 or rank < best_rank:
                best, best_rank = cell, rank
        tail = expand(cells, width, cell, buffers, number, tail, rise)
        head += 1
    return best


@kernel()
def count_known(belief: np.ndarray) -> int:
    """Count the known cells of a (H, W) belief."""
    known = 0
    for value in belief.reshape(belief.size):
        known += value != UNKNOWN
    return known


def map_stamp(view: View) -> int:
    """Return a number that changes whenever the map does: where maps are certain, how many cells are known."""
    return count_known(view.belief) if view.log_odds is None else zlib.crc32(view.belief.tobytes())


def without(belief: Belief, barred: Iterable[Cell]) -> Belief:
    """Return a copy of a (H, W) belief in which some cells are occupied, so that no path leads through them."""
    passable = belief.copy()
    for row, col in barred:
        passable[row, col] = OCCUPIED
    return passable


class Paths:
    """Find paths for one pilot on maps of one shape, with reused buffers; ``rise`` is 0 on maps of one level."""

    def __init__(self, shape: tuple[int, int], rise: int = 0) -> None:
        size = shape[0] * shape[1]
        self.width, self.rise = shape[1], rise
        self._buffers = SearchBuffers(np.empty(size, np.int32), np.empty(size, np.int32), np.zeros(size, np.int32))
        self._number = 0

    def flat(self, cells: Iterable[Cell]) -> Cells:
        """Return K (row, column) cells as flat indices, (K,) int32."""
        return np.array([row * self.width + col for row, col in cells], np.int32)

    def _next(self) -> int:
        self._number += 1
        return self._number

    def to(self, belief: Belief, cell: Cell, goal: Cell, barred: Iterable[Cell] = ()) -> list[Cell] | None:
        """Return a shortest path on a (H, W) belief from ``cell`` to ``goal``, both included; None if there is none."""
        start, end = cell[0] * self.width + cell[1], goal[0] * self.width + goal[1]
        if not search_to(belief, start, end, self.flat(barred), self._buffers, self._next(), self.rise):
            return None
        return self._traced(end)

    def to_frontier(
        self, belief: Belief, cell: Cell, rng: np.random.Generator, avoid: Iterable[Cell] = ()
    ) -> list[Cell] | None:
        """Return a shortest path to the nearest frontier cell, drawn at random among equals; None if unreachable.

        ``belief`` is (H, W); frontier cells near those of ``avoid`` do not count.
        """
        ties = rng.integers(2**64, dtype=np.uint64)
        start = cell[0] * self.width + cell[1]
        end = search_frontier(belief, start, self.flat(avoid), ties, self._buffers, self._next(), self.rise)
        return self._traced(end) if end >= 0 else None

    def to_anywhere(
        self, belief: Belief, cell: Cell, reach: int, rng: np.random.Generator, barred: Iterable[Cell] = ()
    ) -> list[Cell] | None:
        """Return a path to a random other cell at most ``reach`` steps away; None if no move is possible.

        ``belief`` is (H, W). The cell is drawn from the farther half of these cells.
        """
        start = cell[0] * self.width + cell[1]
        found = search_within(belief, start, reach, self.flat(barred), self._buffers, self._next(), self.rise)
        if found < 2:
            return None
        return self._traced(int(self._buffers.queue[int(rng.integers(max(1, found // 2), found))]))

    def field(self, belief: Belief, cell: Cell) -> Distances:
        """Return the (H, W) int32 field of steps from ``cell`` through known free cells."""
        out = np.empty(belief.shape, np.int32)
        distances_from(belief, cell[0], cell[1], self._buffers.queue, out, self.rise)
        return out

    def matrix(self, belief: Belief, cells: Cells, known: Distances | None = None) -> Distances:
        """Return the (K, K) int32 steps between (K,) flat cells; ``UNREACHABLE`` without a known path.

        Entries of ``known`` (K, K) that are not negative are reused, except ``UNREACHABLE`` ones.
        """
        first, self._number = self._number + 1, self._number + len(cells)
        steps = np.full((len(cells), len(cells)), -1, np.int32) if known is None else np.array(known, np.int32)
        steps[steps >= UNREACHABLE] = -1
        np.fill_diagonal(steps, 0)
        fill_distances(belief, cells, steps, self._buffers, first, self.rise)
        return steps

    def _traced(self, end: int) -> list[Cell]:
        flat = path_to(self._buffers.parent, end).tolist()
        return [divmod(place, self.width) for place in flat]
