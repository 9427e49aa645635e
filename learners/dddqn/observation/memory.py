"""The memory, beyond the belief, that a UAV's observations need: one column per UAV. It is updated in changed boxes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import MOVES, UNKNOWN
from indoor_explorers.env.grid.compiled import inner, leaf
from indoor_explorers.env.search.bitsets import ROOM, STRIDE, WORDS
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import PROSPECTS

#: Marks in place of a gain: it must be recomputed; the UAV has been in the cell, which has nothing more to show.
STALE, SPENT = -1, -2
#: Value of each array at the beginning of an episode; the others are overwritten before they are read.
START = {
    **dict.fromkeys(("noted", "visits", "looks", "barred", "pushes", "gained", "idle", "nearest", "theirs"), 0),
    **{"aimed": -1, "chance": 255, "gain": STALE, "prospect": -1, "obstacles": 255, "tour": -1},
}
#: Length of the longest tour that is kept, in cells.
LONGEST = 40


class ObservationMemory(NamedTuple):
    """Arrays of C columns for maps of (H, W) cells; R = 256 if tours are searched, else 0."""

    noted: NDArray[np.uint8]
    """(C, H, W) cells known at the last observation."""
    visits: NDArray[np.uint8]
    """(C, H, W) visits since the last gain."""
    aimed: NDArray[np.int64]
    """(C,) flat target cell of the last move, -1 for none."""
    looks: NDArray[np.int64]
    """(C,) number of observations so far."""
    barred: NDArray[np.int32]
    """(C, H, W) number of the observation until which a cell counts as blocked, after a teammate was in it."""
    pushes: NDArray[np.int64]
    """(C,) blocked moves since the last gain."""
    chance: NDArray[np.uint8]
    """(C, H, W) probability that an unknown cell is free and reachable, 255 standing for 1; 0 for known cells."""
    gain: NDArray[np.int32]
    """(C, H, W) view gain: unknown cells in view of a cell, :data:`STALE` or :data:`SPENT`."""
    weight: NDArray[np.float32]
    """(C, H, W) view gain with isolated cells weighted more; (C, 0, 0) if there are no candidate features."""
    prospect: NDArray[np.int64]
    """(C, 2) flat cell of the best candidate of each kind at the last observation, -1 for none."""
    obstacles: NDArray[np.uint8]
    """(C, H, W) the map with assumed obstacles that ``views`` and ``passages`` were computed for; 255 at first."""
    views: NDArray[np.uint64]
    """(C, R, 4) bit set of the cells visible from each cell, unknown cells being transparent."""
    passages: NDArray[np.int32]
    """(C, R, 4) neighbours of each cell that are not obstacles, known or assumed; -1 for none."""
    tour: NDArray[np.int64]
    """(C, 2, 41) the remaining cells of the best tours found so far, to the goal and to 90 %; -1 after the last."""
    theirs: NDArray[np.uint64]
    """(C, M, 4) bit set of the cells that each teammate got in the last division with it; M = 0 without division."""
    gained: NDArray[np.int64]
    """(C,) cells discovered by the UAV's own lidar so far."""
    idle: NDArray[np.int64]
    """(C,) steps since the last gain."""
    nearest: NDArray[np.int64]
    """(C,) steps to the nearest reachable cell with unknown cells in view, -1 for none."""

    def forget(self, columns: slice | Sequence[int]) -> None:
        """Reset some columns for new episodes."""
        for name, value in START.items():
            getattr(self, name)[columns] = value

    def aim(self, cell: NDArray[np.int64], action: NDArray[np.int64]) -> None:
        """Store the target cells of moves (C,) from cells (C, 2)."""
        height, width = self.noted.shape[1:]
        row, col = (cell + MOVES[action]).T
        inside = (row >= 0) & (row < height) & (col >= 0) & (col < width)
        self.aimed[...] = np.where(inside, row * width + col, -1)


def new_memory(
    columns: int, shape: tuple[int, int], observation: ObservationConfig, team: int = 1
) -> ObservationMemory:
    """Allocate the memory of ``columns`` UAVs on (H, W) maps, with that of tours if the map is small enough."""
    room = STRIDE * ROOM if observation.tours and max(shape) <= ROOM else 0
    cells, single = (columns, *shape), (columns,)
    memory = ObservationMemory(
        noted=np.empty(cells, np.uint8),
        visits=np.empty(cells, np.uint8),
        aimed=np.empty(single, np.int64),
        looks=np.empty(single, np.int64),
        barred=np.empty(cells, np.int32),
        pushes=np.empty(single, np.int64),
        chance=np.empty(cells, np.uint8),
        gain=np.empty(cells, np.int32),
        weight=np.zeros(cells if observation.prospects else (columns, 0, 0), np.float32),
        prospect=np.empty((columns, len(PROSPECTS)), np.int64),
        obstacles=np.empty(cells, np.uint8),
        views=np.zeros((columns, room, WORDS), np.uint64),
        passages=np.zeros((columns, room, 4), np.int32),
        tour=np.empty((columns, 2, LONGEST + 1), np.int64),
        theirs=np.zeros((columns, team * observation.division, WORDS), np.uint64),
        gained=np.empty(single, np.int64),
        idle=np.empty(single, np.int64),
        nearest=np.empty(single, np.int64),
    )
    memory.forget(slice(None))
    return memory


@inner()
def _note_row(belief: np.ndarray, noted: np.ndarray) -> tuple[int, int]:
    """Note the known cells of one row (W,); return the first newly known column and the one after the last."""
    first, after = belief.shape[0], 0
    for c in range(belief.shape[0]):
        if belief[c] != UNKNOWN and noted[c] == 0:
            noted[c], first, after = 1, min(first, c), c + 1
    return first, after


@leaf()
def note(belief: np.ndarray, noted: np.ndarray, boxes: np.ndarray) -> int:
    """Note the known cells of a belief (H, W); write ``boxes`` around the newly known ones and return their number.

    A box is (top, left, bottom, right), the last two exclusive; adjacent rows with changes share one box.
    ``boxes`` must have room for one box in every second row.
    """
    found, joined = 0, False
    for r in range(belief.shape[0]):
        changed = False
        for c in range(belief.shape[1]):  # without a branch, so that the loop is vectorised
            changed |= (belief[r, c] != UNKNOWN) & (noted[r, c] == 0)
        if changed:
            left, right = _note_row(belief[r], noted[r])
            if joined:
                left, right = min(left, boxes[found - 1, 1]), max(right, boxes[found - 1, 3])
            else:
                boxes[found, 0] = r
                found += 1
            boxes[found - 1, 1], boxes[found - 1, 2], boxes[found - 1, 3] = left, r + 1, right
        joined = changed
    return found
