"""Buildings that a plan at one height does not show: lintels, furniture, tall halls, stair wells, crawl spaces.

Storeys are drawn by :class:`~indoor_explorers.env.maps.generators.rooms.RoomsMaps`, each anew, with a slab between each
two. Lintels hang in doorways. Tables have free space below them, shelves between their boards. A hall reaches from the
ground to the roof, and each storey above surrounds it with a gallery. Stair wells pass all storeys; hatches of one cell
lead through a single slab, and crawl spaces under the ceiling through walls.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.generators.rooms import RoomsMaps
from indoor_explorers.env.maps.generators.volumes import Place, VolumeMaps, check_fits, wide
from indoor_explorers.env.search.connected_parts import largest_part

#: Sides of tables in cells, smallest and largest, and the level of their boards.
TABLE, BOARD = (2, 4), 1
#: Sides of shelves in cells; they have a board on every second level from the floor on.
SHELF = ((1, 1), (2, 5))
#: Tries to place a piece of furniture for each cell that furniture shall take.
TRIES = 3


class InteriorsMaps(VolumeMaps):
    """Random buildings of one or more storeys that are furnished, joined and pierced in three dimensions."""

    source: Literal["interiors"] = "interiors"
    storeys: int = Field(1, ge=1, le=32)
    """Storeys, with a slab of one level between each two."""
    storey_height: int = Field(6, ge=2, le=256)
    """Levels from the floor of a storey to its ceiling."""
    headroom: int = Field(4, ge=1, le=256)
    """Levels below the lintels, which hang in passages one cell wide; no shelf is higher."""
    furniture: float = Field(0.15, ge=0.0, le=0.5)
    """Share of the floor that tables and shelves take, about, where they find room."""
    halls: int = Field(0, ge=0, le=16)
    """Halls from the ground to the roof."""
    hall_size: tuple[int, int] = (8, 14)
    """Smallest and largest side of a hall in cells."""
    gallery: int = Field(2, ge=0, le=16)
    """Width in cells of the galleries around a hall on the storeys above the ground."""
    wells: int = Field(0, ge=0, le=16)
    """Stair wells and shafts: rectangles without slabs through all storeys."""
    well_size: tuple[int, int] = (1, 3)
    """Smallest and largest side of a stair well in cells."""
    hatches: int = Field(1, ge=1, le=64)
    """Openings of one cell in each slab."""
    crawl_spaces: int = Field(0, ge=0, le=64)
    """Crawl spaces of each storey, one cell wide and high: with a bend, from a free cell to another one."""
    room_size: tuple[int, int] = (4, 9)
    """Smallest and largest side of a room in cells."""
    corridor: int = Field(2, ge=1, le=64)
    """Cells from wall to wall of a corridor."""

    @model_validator(mode="after")
    def _consistent(self) -> InteriorsMaps:
        check_fits(self, "well_size", self.well_size)
        check_fits(self, "hall_size", self.hall_size)
        if self.headroom > self.storey_height:
            raise ValueError(f"headroom is {self.headroom}, more than storey_height {self.storey_height}; lower it")
        self._plans  # noqa: B018  # refuses rooms that do not fit
        return self

    @property
    def level_count(self) -> int:
        """Levels of the maps: those of the storeys and the slabs between them."""
        return self.storeys * (self.storey_height + 1) - 1

    @property
    def _plans(self) -> RoomsMaps:
        """The generator of a storey's plan."""
        return RoomsMaps(height=self.height, width=self.width, room_size=self.room_size, corridor=self.corridor)

    def draw(self, rng: np.random.Generator) -> Mask:
        """Return the (levels, height, width) mask of the free cells of a building."""
        free = np.zeros((self.level_count, self.height, self.width), np.bool_)
        plans = [self._plans.draw(rng) for _ in range(self.storeys)]
        for plan, storey in zip(plans, self._storeys(free), strict=True):
            storey[:] = plan
            storey[self.headroom :] &= wide(plan)
            self._furnish(rng, storey)
            for _ in range(self.crawl_spaces):
                _crawl(rng, plan, storey[-1])
        for _ in range(self.halls):
            self._open_hall(rng, free)
        for _ in range(self.wells):
            free[:, *self.rectangle(rng, self.well_size)] = True
        for slab in range(self.storey_height, self.level_count, self.storey_height + 1):
            places = np.argwhere(free[slab - 1] & free[slab + 1])
            for row, col in rng.permutation(places)[: self.hatches]:
                free[slab, row, col] = True
        return largest_part(free)

    def _storeys(self, free: Mask) -> Iterator[Mask]:
        """Yield the levels (K, H, W) of each storey."""
        for floor in range(0, self.level_count, self.storey_height + 1):
            yield free[floor : floor + self.storey_height]

    def _furnish(self, rng: np.random.Generator, storey: Mask) -> None:
        """Put tables and shelves where a random place on the floor of a storey (K, H, W) has room for one."""
        floor = wide(storey[0])
        left = int(self.furniture * floor.sum())
        for _ in range(TRIES * left):
            table = rng.random() < 0.5
            place = self._footprint(rng, (TABLE, TABLE) if table else SHELF)
            if left > 0 and floor[place].all():
                boards = [BOARD] if table else list(range(0, self.headroom, 2))
                storey[boards, *place] = floor[place] = False
                left -= floor[place].size

    def _footprint(self, rng: np.random.Generator, sides: tuple[tuple[int, int], tuple[int, int]]) -> Place:
        """Return the place of a piece of furniture of such sides, either way round."""
        lengths = [int(rng.integers(low, high + 1)) for low, high in sides]
        tall, across = lengths if rng.random() < 0.5 else lengths[::-1]
        row, col = int(rng.integers(1, self.height - 1)), int(rng.integers(1, self.width - 1))
        return slice(row, row + tall), slice(col, col + across)

    def _open_hall(self, rng: np.random.Generator, free: Mask) -> None:
        """Open a hall through all levels (L, H, W), with a gallery on each storey but the ground."""
        hall = self.rectangle(rng, self.hall_size)
        free[:, *hall] = True
        sides = zip(hall, (self.height, self.width), strict=True)
        around = [
            slice(max(1, part.start - self.gallery), min(side - 1, part.stop + self.gallery)) for part, side in sides
        ]
        for storey in list(self._storeys(free))[1:]:
            storey[:, *around] = True


def _crawl(rng: np.random.Generator, plan: Mask, level: Mask) -> None:
    """Open a crawl space on a level (H, W): along the row of one free cell of the plan, and the column of another."""
    (row, col), (end, last) = rng.choice(np.argwhere(plan), 2)
    level[row, min(col, last) : max(col, last) + 1] = True
    level[min(row, end) : max(row, end) + 1, last] = True
