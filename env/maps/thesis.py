"""The thesis's random rooms: rectangles thrown into an open rectangle (MarsExplorer's generator).

Compiled and drawn from a counter-based stream, so that thousands of episodes start in a moment.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.env.compiled import leaf
from indoor_explorers.env.grid import FREE, OCCUPIED
from indoor_explorers.env.randomness import below


class Room(NamedTuple):
    """The settings of a random room, see :class:`indoor_explorers.env.maps.sources.ThesisMaps`."""

    obstacles: int
    smallest: int
    largest: int
    margin: int
    rows: int
    """Rows of the lattice, 0 for none."""
    columns: int
    noise: int


@leaf()
def _on_lattice(place: int, places: int, margin: int, cells: int) -> int:
    """Return the row or column of the lattice's line ``place``, evenly spread between the margins."""
    last = max(cells - 1 - margin, margin)
    return margin + place * (last - margin) // max(places - 1, 1)


@leaf()
def draw_room(room: Room, key: np.uint64, truth: np.ndarray) -> None:
    """Overwrite ``truth`` (H, W) uint8 with the room of a stream's key.

    Without a lattice, a rectangle's upper left cell is uniform with at least ``margin`` cells to the upper and
    left and ``margin`` + 1 to the lower and right border, as the ancestor does; with one, rectangles stand where
    its rows and columns cross, moved by up to ``noise`` cells each way. What hangs over the border is cut off, and
    rectangles may overlap.
    """
    height, width = truth.shape
    for row in range(height):
        for col in range(width):
            truth[row, col] = FREE
    lattice, margin, sides = room.rows > 0, room.margin, room.largest - room.smallest + 1
    for k in range(room.rows * room.columns if lattice else room.obstacles):
        if lattice:
            row = _on_lattice(k // room.columns, room.rows, margin, height)
            col = _on_lattice(k % room.columns, room.columns, margin, width)
            row = min(max(row + below(key, 4 * k, 2 * room.noise + 1) - room.noise, 0), height - 1)
            col = min(max(col + below(key, 4 * k + 1, 2 * room.noise + 1) - room.noise, 0), width - 1)
        else:
            row = margin + below(key, 4 * k, max(height - 1 - 2 * margin, 1))
            col = margin + below(key, 4 * k + 1, max(width - 1 - 2 * margin, 1))
        tall = room.smallest + below(key, 4 * k + 2, sides)
        wide = room.smallest + below(key, 4 * k + 3, sides)
        for r in range(row, min(row + tall, height)):
            for c in range(col, min(col + wide, width)):
                truth[r, c] = OCCUPIED
