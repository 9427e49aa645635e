"""What a UAV must remember, beyond its belief, to observe: one column for each UAV."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.env.search.bitsets import ROOM, STRIDE, WORDS
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import PROSPECTS

#: A gain that is to be counted, and that of a cell where the UAV has been: it has seen what there is to see from there.
STALE, SPENT = -1, -2
#: Cells of the longest tour that is remembered.
LONGEST = 40


class ObservationMemory(NamedTuple):
    """Arrays of C columns for maps of (H, W) cells; R = 256 where tours are planned and 0 elsewhere."""

    noted: NDArray[np.uint8]
    """(C, H, W) cells known at the last look."""
    visits: NDArray[np.uint8]
    """(C, H, W) visits since the last gain."""
    aimed: NDArray[np.int64]
    """(C,) flat cell that the last move was to lead to, -1 for none."""
    looks: NDArray[np.int64]
    """(C,) looks taken so far."""
    barred: NDArray[np.int32]
    """(C, H, W) the look until which a cell is taken for blocked, since a teammate was in the way to it."""
    pushes: NDArray[np.int64]
    """(C,) how often one was since the last gain."""
    chance: NDArray[np.uint8]
    """(C, H, W) chance of an unknown cell to count, 255 for certainly; 0 for known cells."""
    gain: NDArray[np.int32]
    """(C, H, W) unknown cells in view of a cell, -1 where they are to be counted anew, -2 where the UAV has been."""
    weight: NDArray[np.float32]
    """(C, H, W) how much these count when isolated ones count more; empty maps where prospects are not looked for."""
    prospect: NDArray[np.int64]
    """(C, 2) flat cell of the best prospect of each kind at the last look, -1 for none."""
    obstacles: NDArray[np.uint8]
    """(C, H, W) obstacles, known and assumed, that ``views`` and ``passages`` reckon with; 255 before the first."""
    views: NDArray[np.uint64]
    """(C, R, 4) what is visible from each cell, unknown cells being transparent, as bits."""
    passages: NDArray[np.int32]
    """(C, R, 4) neighbours that are not taken for obstacles, -1 for none."""
    tour: NDArray[np.int64]
    """(C, 2, 41) the rest of the best tours found so far, to the goal and to the mark on the way: cells, then -1."""
    gained: NDArray[np.int64]
    """(C,) cells gained by the own lidar so far."""
    idle: NDArray[np.int64]
    """(C,) steps since the last gain."""
    nearest: NDArray[np.int64]
    """(C,) steps to the nearest place that shows something unknown, -1 when nothing within reach is unknown."""

    def forget(self, columns: slice | Sequence[int]) -> None:
        """Begin some columns anew."""
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
        """Remember where the moves (C,) that are made now from cells (C, 2) are to lead to."""
        height, width = self.noted.shape[1:]
        row, col = (cell + MOVES[action]).T
        inside = (row >= 0) & (row < height) & (col >= 0) & (col < width)
        self.aimed[...] = np.where(inside, row * width + col, -1)


def new_memory(columns: int, shape: tuple[int, int], observation: ObservationConfig) -> ObservationMemory:
    """Allocate the memory of ``columns`` UAVs on (H, W) maps, for tours where the map is small enough."""
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
