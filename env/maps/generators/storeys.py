"""Buildings of several storeys: rooms and corridors on each, joined by openings in the slabs and by high halls.

Storeys are drawn by :class:`~indoor_explorers.env.maps.generators.rooms.RoomsMaps`, each anew. A UAV gets from one to
the next through openings in the slab between them, such as stair wells and shafts, and through halls: rooms without a
slab above, which the storey above surrounds with galleries wherever its corridors and rooms meet them. Tables and
shelves stand on the floors.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.base import GeneratedMaps
from indoor_explorers.env.maps.generators.rooms import RoomsMaps
from indoor_explorers.env.maps.generators.volumes import check_fits
from indoor_explorers.env.search.connected_parts import largest_part


class StoreysMaps(GeneratedMaps):
    """Random buildings of several storeys, one level of cells for each cell of height."""

    source: Literal["storeys"] = "storeys"
    storeys: int = Field(2, ge=1, le=32)
    """Storeys, with a slab of one level between each two."""
    storey_height: int = Field(3, ge=1, le=256)
    """Levels from the floor of a storey to its ceiling."""
    openings: int = Field(2, ge=1, le=64)
    """Openings in each slab."""
    opening_size: tuple[int, int] = (1, 3)
    """Smallest and largest side of an opening in cells."""
    halls: int = Field(1, ge=0, le=64)
    """Halls in each slab: rectangles of the storey below without a slab above."""
    hall_size: tuple[int, int] = (6, 12)
    """Smallest and largest side of a hall in cells."""
    furniture: float = Field(0.05, ge=0.0, le=0.5)
    """Share of the floor's cells with an obstacle on them, up to half as high as the storey."""
    room_size: tuple[int, int] = (5, 14)
    """Smallest and largest side of a room in cells."""
    corridor: int = Field(2, ge=1, le=64)
    """Cells from wall to wall of a corridor."""

    @model_validator(mode="after")
    def _consistent(self) -> StoreysMaps:
        check_fits(self, "opening_size", self.opening_size)
        check_fits(self, "hall_size", self.hall_size)
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
        for storey, plan in enumerate(plans):
            floor = storey * (self.storey_height + 1)
            free[floor : floor + self.storey_height] = plan
            self._furnish(rng, free[floor : floor + (self.storey_height + 1) // 2], plan)
        for storey, (below, above) in enumerate(pairwise(plans)):
            slab = (storey + 1) * (self.storey_height + 1) - 1
            for _ in range(self.openings):
                free[slab] |= below & above & self._rectangle(rng, self.opening_size, below & above)
            for _ in range(self.halls):
                hall = self._rectangle(rng, self.hall_size, below) & below
                free[slab : slab + self.storey_height + 1] |= hall
        return largest_part(free)

    def _furnish(self, rng: np.random.Generator, lower: Mask, plan: Mask) -> None:
        """Put tables and shelves into the lower levels (K, H, W) of a storey."""
        heights = rng.integers(1, len(lower) + 1, size=plan.shape) * (rng.random(plan.shape) < self.furniture)
        lower &= ~(plan & (np.arange(len(lower))[:, None, None] < heights))

    def _rectangle(self, rng: np.random.Generator, sizes: tuple[int, int], around: Mask) -> Mask:
        """Return the mask of a random rectangle within the walls whose first cell is one of ``around`` (H, W)."""
        tall, wide = rng.integers(sizes[0], sizes[1] + 1, size=2).tolist()
        mask, places = np.zeros(around.shape, np.bool_), np.argwhere(around)
        row, col = places[rng.integers(len(places))] if len(places) else (1, 1)
        mask[row : row + tall, col : col + wide] = True
        mask[[0, -1]] = mask[:, [0, -1]] = False
        return mask
