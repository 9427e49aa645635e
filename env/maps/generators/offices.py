"""Office floors: parallel corridors with a row of rooms on each side, cross corridors, doors and furniture.

The plan is the double-loaded corridor of most office buildings; the bundled ``office`` is drawn by hand instead.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.base import GeneratedMaps, check_room, check_sizes
from indoor_explorers.env.maps.generators.furniture import furnish

#: A meeting table is at most this deep and long, in cells, and this far from the walls.
TABLE, AROUND = (3, 8), 2


class OfficeRow(NamedTuple):
    """A row of rooms beside a corridor."""

    top: int
    depth: int
    door: int
    """The row of cells of the wall to the corridor."""
    broken: bool
    """True when cross corridors cut through it."""


class OfficesMaps(GeneratedMaps):
    """Random office floors; the corridors run along the longer side."""

    source: Literal["offices"] = "offices"
    corridor: int = Field(3, ge=1, le=64)
    """Cells from wall to wall of a corridor."""
    room_depth: tuple[int, int] = (6, 12)
    """Smallest and largest depth of a room in cells; on floors that no whole number of rows fits, some are deeper."""
    room_width: tuple[int, int] = (5, 14)
    """Smallest and largest length of a room along its corridor in cells; stretched where none fits."""
    door: tuple[int, int] = (1, 2)
    """Narrowest and widest door in cells."""
    crossing: int = Field(60, ge=1)
    """Cells along a corridor for each cross corridor; there is at least one where there are several corridors."""
    links: float = Field(0.1, ge=0.0, le=1.0)
    """Share of neighbouring rooms with a door between them."""
    meeting: float = Field(0.15, ge=0.0, le=1.0)
    """Share of rooms with a meeting table in the middle, where it fits."""
    furniture: float = Field(0.12, ge=0.0, le=0.5)
    """Share of the floor of the other rooms under furniture."""

    @model_validator(mode="after")
    def _consistent(self) -> OfficesMaps:
        check_sizes("room_depth", self.room_depth)
        check_sizes("room_width", self.room_width)
        check_sizes("door", self.door)
        shorter, longer = sorted([("height", self.height), ("width", self.width)], key=lambda side: side[1])
        check_room(*shorter, self.room_depth[0] + self.corridor + 3, "a corridor, a row of rooms and three walls")
        check_room(*longer, self.room_width[0] + self.corridor + 3, "a cross corridor, a room and three walls")
        return self

    def draw(self, rng: np.random.Generator) -> Mask:
        """Return the (height, width) mask of corridors, rooms and doors, without the furniture's cells."""
        turned = self.height > self.width
        deep, long = (self.width, self.height) if turned else (self.height, self.width)
        free = np.zeros((deep, long), np.bool_)
        rows, corridors = self._rows(rng, deep)
        for top in corridors:
            free[top : top + self.corridor, 1:-1] = True
        segments = [(1, long - 2)]
        if len(corridors) > 1:
            crossings, segments = self._crossings(rng, long - 2)
            for left in crossings:
                free[corridors[0] : corridors[-1] + self.corridor, left : left + self.corridor] = True
        plain = [
            room
            for row in rows
            for start, length in (segments if row.broken else [(1, long - 2)])
            for room in self._rooms(rng, free, row, start, length)
        ]
        rooms = np.array(plain, np.int64).reshape(-1, 4)
        furnish(free, rooms, self.furniture, rng.integers(2**64, dtype=np.uint64))
        return np.ascontiguousarray(free.T) if turned else free

    def _rows(self, rng: np.random.Generator, deep: int) -> tuple[list[OfficeRow], list[int]]:
        """Return the rows of rooms from the top down, and the first row of cells of each corridor."""
        smallest, largest = self.room_depth
        aisle = self.corridor + 2
        spare = {count: deep - 1 - count * (aisle + 1) for count in range(1, deep // (aisle + 1) + 1)}
        fits = [count for count, depth in spare.items() if depth >= 2 * count * smallest]
        if not fits:
            depth = deep - 3 - self.corridor
            return [OfficeRow(self.corridor + 2, depth, self.corridor + 1, broken=False)], [1]
        good = [count for count in fits if spare[count] <= 2 * count * largest] or fits[-1:]
        count = good[int(rng.integers(len(good)))]
        rows, corridors, top = [], [], 1
        for number, depth in enumerate(shares(rng, spare[count], 2 * count, smallest, largest)):
            if number % 2 == 0:
                rows.append(OfficeRow(top, depth, top + depth, broken=number > 0))
                corridors.append(top + depth + 1)
                top += depth + aisle
            else:
                rows.append(OfficeRow(top, depth, top - 1, broken=number < 2 * count - 1))
                top += depth + 1
        return rows, corridors

    def _crossings(self, rng: np.random.Generator, long: int) -> tuple[list[int], list[tuple[int, int]]]:
        """Return the starts of cross corridors, and the (start, length) of the segments between them."""
        smallest = self.room_width[0]
        for count in range(max(1, round(long / self.crossing)), 0, -1):
            spare = long - count * (self.corridor + 2)
            if spare >= (count + 1) * smallest:
                break
        else:  # too short for rooms on both sides
            return [1], [(2 + self.corridor, long - self.corridor - 1)]
        lengths = shares(rng, spare, count + 1, smallest, 2 * spare // (count + 1))
        starts = np.cumsum([1, *(length + self.corridor + 2 for length in lengths[:-1])])
        return [int(start) + length + 1 for start, length in zip(starts[:-1], lengths[:-1], strict=True)], [
            (int(start), length) for start, length in zip(starts, lengths, strict=True)
        ]

    def _rooms(
        self, rng: np.random.Generator, free: Mask, row: OfficeRow, start: int, length: int
    ) -> Iterator[tuple[int, int, int, int]]:
        """Build the rooms of a part of a row; yield (top, left, depth, width) of the rooms to be furnished."""
        left = start
        for number, width in enumerate(room_lengths(rng, length, *self.room_width)):
            free[row.top : row.top + row.depth, left : left + width] = True
            self._open(rng, free[row.door, left : left + width])
            if number and rng.random() < self.links:
                self._open(rng, free[row.top : row.top + row.depth, left - 1])
            if not (rng.random() < self.meeting and set_table(free, row.top, left, row.depth, width)):
                yield row.top, left, row.depth, width
            left += width + 1

    def _open(self, rng: np.random.Generator, wall: Mask) -> None:
        """Open a door in a strip of wall."""
        width = min(int(rng.integers(self.door[0], self.door[1] + 1)), len(wall))
        start = int(rng.integers(len(wall) - width + 1))
        wall[start : start + width] = True


def shares(rng: np.random.Generator, total: int, count: int, smallest: int, largest: int) -> list[int]:
    """Divide ``total`` cells at random into ``count`` parts from ``smallest`` to ``largest`` cells.

    Where that cannot be, the bounds give way as far as needed.
    """
    smallest, largest = min(smallest, total // count), max(largest, -(-total // count))
    parts = []
    for left in range(count - 1, -1, -1):
        low, high = max(smallest, total - left * largest), min(largest, total - left * smallest)
        parts.append(int(rng.integers(low, high + 1)))
        total -= parts[-1]
    return parts


def room_lengths(rng: np.random.Generator, length: int, smallest: int, largest: int) -> list[int]:
    """Divide a row of ``length`` cells at random into rooms with walls of one cell between; return their lengths."""
    counts = max(1, -(-(length + 1) // (largest + 1))), max(1, (length + 1) // (smallest + 1))
    count = int(rng.integers(counts[0], max(counts) + 1))
    return shares(rng, length - count + 1, count, smallest, largest)


def set_table(free: Mask, top: int, left: int, depth: int, width: int) -> bool:
    """Put a table with chairs in the middle of a free room, if there is space all around it; tell whether there was."""
    tall, wide = min(depth - 2 * AROUND, TABLE[0]), min(width - 2 * AROUND, TABLE[1])
    if min(tall, wide) < 1:
        return False
    row, col = top + (depth - tall) // 2, left + (width - wide) // 2
    free[row : row + tall, col : col + wide] = False
    free[[row - 1, row + tall], col : col + wide : 2] = False
    return True
