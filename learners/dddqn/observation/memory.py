"""The memory, beyond the belief, that a UAV's observations need: one column per UAV."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.env.search.bitsets import ROOM, STRIDE, WORDS
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import PROSPECTS

#: Marks in place of a gain: it must be recomputed; the UAV has been in the cell, which has nothing more to show.
STALE, SPENT = -1, -2
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
    gained: NDArray[np.int64]
    """(C,) cells discovered by the UAV's own lidar so far."""
    idle: NDArray[np.int64]
    """(C,) steps since the last gain."""
    nearest: NDArray[np.int64]
    """(C,) steps to the nearest reachable cell with unknown cells in view, -1 for none."""

    def forget(self, columns: slice | Sequence[int]) -> None:
        """Reset some columns for new episodes."""
        self.noted[columns] = 0
        self.visits[columns] = 0
        self.aimed[columns] = -1
        self.looks[columns] = self.pushes[columns] = 0
        self.barred[columns] = 0
        self.chance[columns] = 255
        self.gain[columns] = STALE
        self.prospect[columns] = -1
        self.obstacles[columns] = 255
        self.tour[columns] = -1
        self.gained[columns] = 0
        self.idle[columns] = 0
        self.nearest[columns] = 0

    def aim(self, cell: NDArray[np.int64], action: NDArray[np.int64]) -> None:
        """Store the target cells of moves (C,) from cells (C, 2)."""
        height, width = self.noted.shape[1:]
        row, col = (cell + MOVES[action]).T
        inside = (row >= 0) & (row < height) & (col >= 0) & (col < width)
        self.aimed[...] = np.where(inside, row * width + col, -1)


def new_memory(columns: int, shape: tuple[int, int], observation: ObservationConfig) -> ObservationMemory:
    """Allocate the memory of ``columns`` UAVs on (H, W) maps, with that of tours if the map is small enough."""
    cells = (columns, *shape)
    room = STRIDE * ROOM if observation.tours and max(shape) <= ROOM else 0
    memory = ObservationMemory(
        noted=np.zeros(cells, np.uint8),
        visits=np.zeros(cells, np.uint8),
        aimed=np.zeros(columns, np.int64),
        looks=np.zeros(columns, np.int64),
        barred=np.zeros(cells, np.int32),
        pushes=np.zeros(columns, np.int64),
        chance=np.zeros(cells, np.uint8),
        gain=np.zeros(cells, np.int32),
        weight=np.zeros(cells if observation.prospects else (columns, 0, 0), np.float32),
        prospect=np.zeros((columns, len(PROSPECTS)), np.int64),
        obstacles=np.zeros(cells, np.uint8),
        views=np.zeros((columns, room, WORDS), np.uint64),
        passages=np.zeros((columns, room, 4), np.int32),
        tour=np.zeros((columns, 2, LONGEST + 1), np.int64),
        gained=np.zeros(columns, np.int64),
        idle=np.zeros(columns, np.int64),
        nearest=np.zeros(columns, np.int64),
    )
    memory.forget(slice(None))
    return memory
