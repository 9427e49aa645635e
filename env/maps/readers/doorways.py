"""Open doorways that a source leaves unknown.

Floor plans converted to occupancy maps often contain only each room's outline, and the space between two outlines is
unknown even in a doorway, so that every room would be closed.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, UNKNOWN
from indoor_explorers.env.search.connected_parts import connected_parts

#: A doorway is at most this deep, in metres: the thickness of a wall.
DEPTH = 1.2
#: A doorway leads into a room of at least this size, in square metres; smaller free areas are sensor noise.
ROOM = 1.0


def open_doorways(cells: Belief, resolution: float) -> Belief:
    """Return (H, W) uint8 ``cells`` with doorways free; ``resolution`` is metres a pixel.

    A doorway is a straight strip of unknown pixels, along a row or a column and at most :data:`DEPTH` long, between the
    free floors of two rooms that are not connected otherwise.
    """
    labels, sizes = connected_parts(cells == FREE)
    rooms = sizes * resolution**2 >= ROOM
    rooms[0] = False
    if rooms.sum() < 2 or not (cells == UNKNOWN).any():
        return cells
    room = np.where(rooms[labels], labels, 0).astype(np.int32)
    depth = int(DEPTH / resolution + 1e-9)
    found = _strips(cells, room, depth) | _strips(cells.T, room.T, depth).T
    return np.where(found, FREE, cells)


def _strips(cells: Belief, room: NDArray[np.int32], depth: int) -> NDArray[np.bool_]:
    """Mark the unknown pixels between two rooms of a row that are at most ``depth`` pixels apart."""
    known = cells != UNKNOWN
    before = _nearest_before(known)
    after = cells.shape[1] - 1 - _nearest_before(known[:, ::-1])[:, ::-1]
    inside = ~known & (before >= 0) & (after < cells.shape[1]) & (after - before <= depth + 1)
    rows, cols = np.nonzero(inside)
    left, right = room[rows, before[rows, cols]], room[rows, after[rows, cols]]
    joins = (left > 0) & (right > 0) & (left != right)
    marked = np.zeros(cells.shape, np.bool_)
    marked[rows[joins], cols[joins]] = True
    return marked


def _nearest_before(known: NDArray[Any]) -> NDArray[np.int32]:
    """Return for each pixel the column of the last known pixel at or before it in its row, -1 where none is."""
    columns = np.arange(known.shape[1], dtype=np.int32)
    return np.maximum.accumulate(np.where(known, columns, np.int32(-1)), axis=1)
