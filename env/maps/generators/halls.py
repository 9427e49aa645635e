"""Halls: one large room, with columns, desks or racks or without, and rows of rooms along some of its walls.

Open-plan offices, laboratories with side rooms, exhibition halls and warehouses with aisles are such floors.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.base import GeneratedMaps, check_room, check_sizes
from indoor_explorers.env.maps.generators.furniture import furnish
from indoor_explorers.env.maps.generators.offices import room_lengths

#: Least side of the hall itself in cells; a row of rooms that would leave less is left out.
LEAST_HALL = 8
#: Share of the places for desks that stay empty, and smallest and largest sides of a group of desks in cells.
EMPTY, DESK_DEPTH, DESK_LENGTH = 0.25, (2, 3), (2, 7)
#: Smallest and largest depth of a rack in cells.
RACK_DEPTH = (1, 3)

Content = Literal["nothing", "columns", "desks", "racks"]
#: Top, left, height and width in cells.
Room = tuple[int, int, int, int]
#: What stands in halls, and in which share of them: on maps of real ones, little does.
CONTENTS: tuple[Content, ...] = ("nothing", "columns", "desks", "racks")
SHARES = (0.4, 0.3, 0.15, 0.15)


class HallsMaps(GeneratedMaps):
    """Random halls, empty or filled with columns, desks or racks."""

    source: Literal["halls"] = "halls"
    content: Content | None = None
    """What stands in the hall; None: drawn at random for each map."""
    spacing: tuple[int, int] = (6, 12)
    """Smallest and largest distance of columns in cells."""
    aisle: tuple[int, int] = (2, 5)
    """Narrowest and widest way between desks or racks in cells."""
    rack_length: tuple[int, int] = (8, 24)
    """Smallest and largest length of a rack in cells."""
    side_rooms: float = Field(0.6, ge=0.0, le=1.0)
    """Share of the hall's four sides with a row of rooms."""
    room_depth: tuple[int, int] = (4, 14)
    """Smallest and largest depth of a side room in cells."""
    room_width: tuple[int, int] = (4, 16)
    """Smallest and largest length of a side room along the wall in cells."""
    furniture: float = Field(0.02, ge=0.0, le=0.5)
    """Share of the floor of side rooms under furniture."""

    @model_validator(mode="after")
    def _consistent(self) -> HallsMaps:
        for name in ("spacing", "aisle", "rack_length", "room_depth", "room_width"):
            check_sizes(name, getattr(self, name))
        if self.spacing[0] < 3:
            raise ValueError(f"spacing is {list(self.spacing)}, expected at least 3 cells, so that UAVs pass")
        for name in ("height", "width"):
            check_room(name, getattr(self, name), LEAST_HALL + 2, "a hall between two walls")
        return self

    def draw(self, rng: np.random.Generator) -> Mask:
        """Return the (height, width) mask of the hall and its rooms."""
        free = np.zeros((self.height, self.width), np.bool_)
        free[1:-1, 1:-1] = True
        content = self.content or CONTENTS[int(rng.choice(len(CONTENTS), p=SHARES))]
        cells = np.arange(free.size).reshape(free.shape)
        hall, places, rooms, walls = free[1:-1, 1:-1], cells[1:-1, 1:-1], list[Room](), list[Mask]()
        for _ in range(4):
            depth = self._row(rng, hall, places, rooms, walls) if rng.random() < self.side_rooms else 0
            hall, places = np.rot90(hall[depth:]), np.rot90(places[depth:])
        for wall in walls:  # once all walls stand, as a door must not end at one
            _open_door(rng, wall)
        if content == "columns":
            self._columns(rng, hall)
        elif content != "nothing":
            self._groups(rng, hall if hall.shape[0] < hall.shape[1] else hall.T, racks=content == "racks")
        furnish(free, np.array(rooms, np.int64).reshape(-1, 4), self.furniture, rng.integers(2**64, dtype=np.uint64))
        return free

    def _row(
        self, rng: np.random.Generator, hall: Mask, places: NDArray[np.int64], rooms: list[Room], walls: list[Mask]
    ) -> int:
        """Build a row of rooms in the first rows of the hall; return how many rows it takes, 0 where it does not fit.

        ``rooms`` and ``walls`` get each room and its wall to the hall: two rows of cells, those of the wall and those
        behind it.
        """
        depth, left = int(rng.integers(self.room_depth[0], self.room_depth[1] + 1)), 0
        if hall.shape[0] - depth - 1 < LEAST_HALL:
            return 0
        hall[depth] = False
        for width in room_lengths(rng, hall.shape[1], *self.room_width):
            hall[:depth, left + width : left + width + 1] = False
            rows, cols = np.divmod(places[:depth, left : left + width], self.width)
            rooms.append((int(rows.min()), int(cols.min()), int(np.ptp(rows)) + 1, int(np.ptp(cols)) + 1))
            walls.append(hall[depth : depth + 2, left : left + width])
            left += width + 1
        return depth + 1

    def _columns(self, rng: np.random.Generator, hall: Mask) -> None:
        """Put columns of one cell on a lattice, none beside a wall."""
        down, across = (int(rng.integers(self.spacing[0], self.spacing[1] + 1)) for _ in range(2))
        hall[1 + down // 2 : -1 : down, 1 + across // 2 : -1 : across] = False

    def _groups(self, rng: np.random.Generator, hall: Mask, *, racks: bool) -> None:
        """Put rows of desks or racks along the longer side of the hall, with ways all around each."""
        depths, lengths = (RACK_DEPTH, self.rack_length) if racks else (DESK_DEPTH, DESK_LENGTH)
        way = int(rng.integers(self.aisle[0], self.aisle[1] + 1))
        depth = int(rng.integers(depths[0], depths[1] + 1))
        length = min(int(rng.integers(lengths[0], lengths[1] + 1)), hall.shape[1] - 2 * way)
        if length < 1:
            return
        for top in range(way, hall.shape[0] - depth - way + 1, depth + way):
            for left in range(way, hall.shape[1] - length - way + 1, length + way):
                if racks or rng.random() >= EMPTY:
                    hall[top : top + depth, left : left + length] = False


def _open_door(rng: np.random.Generator, wall: Mask) -> None:
    """Open a door of one cell in a wall, where there is floor behind it if possible, and clear what is behind it."""
    places = np.flatnonzero(wall[1])
    place = places[int(rng.integers(len(places)))] if len(places) else int(rng.integers(wall.shape[1]))
    wall[:, place] = True
