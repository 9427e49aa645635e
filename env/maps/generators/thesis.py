"""The thesis's random rooms: rectangular obstacles at random places of an open rectangle (MarsExplorer's generator).

The generator is compiled and draws from a counter-based stream, so that thousands of episodes start quickly.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.grid.compiled import leaf
from indoor_explorers.env.grid.randomness import Stream, below, stream_key
from indoor_explorers.env.maps.base import BaseMaps, check_sizes
from indoor_explorers.env.maps.floorplan import Floorplan


class Room(NamedTuple):
    """The settings of a random room, see :class:`ThesisMaps`."""

    obstacles: int
    smallest: int
    largest: int
    margin: int
    rows: int
    """Rows of the lattice, 0 for none."""
    columns: int
    noise: int


@leaf(entry=False)
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


class ThesisMaps(BaseMaps):
    """Random rooms as in the thesis."""

    source: Literal["thesis"] = "thesis"
    height: int = Field(16, ge=2, le=2048)
    """Cells."""
    width: int = Field(16, ge=2, le=2048)
    """Cells."""
    obstacles: int = Field(5, ge=0, le=100_000)
    """Number of rectangular obstacles; they may overlap."""
    obstacle_size: tuple[int, int] = (3, 3)
    """Smallest and largest side of a rectangle in cells."""
    margin: int = Field(1, ge=0)
    """Cells kept free between the border and a rectangle's upper left cell."""
    rows: int = Field(0, ge=0, le=1000)
    """Rows of a lattice of rectangles, used instead of ``obstacles``; 0 for none."""
    columns: int = Field(0, ge=0, le=1000)
    """Columns of the lattice."""
    noise: int = Field(0, ge=0, le=2048)
    """Cells that a rectangle of the lattice may be moved by, up to, in each direction."""

    @model_validator(mode="after")
    def _consistent(self) -> ThesisMaps:
        check_sizes("obstacle_size", self.obstacle_size)
        if (self.rows > 0) != (self.columns > 0):
            raise ValueError(f"rows is {self.rows} and columns {self.columns}, expected both or neither above 0")
        if self.noise > 0 and self.rows == 0:
            raise ValueError(f"noise is {self.noise} without a lattice; set rows and columns too")
        return self

    @property
    def generated(self) -> bool:
        """True: every seed has a room of its own."""
        return True

    @property
    def room(self) -> Room:
        """The settings for compiled code."""
        smallest, largest = self.obstacle_size
        return Room(self.obstacles, smallest, largest, self.margin, self.rows, self.columns, self.noise)

    def floorplan(self, index: int, seed: int, attempt: int = 0) -> Floorplan:
        """Draw the room of an episode seed."""
        truth = np.empty((self.height, self.width), np.uint8)
        draw_room(self.room, np.uint64(stream_key(seed, Stream.MAP, attempt)), truth)
        return Floorplan(truth, "thesis")
