"""Warehouses: racks between aisles, whose boards, gaps and goods only a UAV at the right height sees into or passes."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.base import check_room, check_sizes
from indoor_explorers.env.maps.generators.volumes import VolumeMaps
from indoor_explorers.env.search.connected_parts import largest_part


class RacksMaps(VolumeMaps):
    """Random warehouses: one room, racks along its longer axis, a way around each."""

    source: Literal["racks"] = "racks"
    levels: int = Field(10, ge=2, le=256)
    """Levels from the floor to the roof; the highest one is above all racks."""
    aisle: tuple[int, int] = (2, 3)
    """Narrowest and widest way between two racks in cells."""
    depth: tuple[int, int] = (1, 3)
    """Smallest and largest depth of a rack in cells."""
    bay: int = Field(4, ge=1, le=64)
    """Cells between two uprights of a rack."""
    gap: int = Field(3, ge=1, le=64)
    """Levels between two boards, and between the floor and the lowest one."""
    goods: float = Field(0.6, ge=0.0, le=1.0)
    """Share of the bays' shelves with goods on them, which fill some of the width, the depth and the height."""

    @model_validator(mode="after")
    def _consistent(self) -> RacksMaps:
        check_sizes("aisle", self.aisle)
        check_sizes("depth", self.depth)
        check_room("height", self.height, 2 * self.aisle[1] + self.depth[1] + 2, "a rack between two aisles")
        check_room("width", self.width, 2 * self.aisle[1] + self.bay + 4, "a bay between two aisles")
        return self

    @property
    def level_count(self) -> int:
        """Levels of the maps."""
        return self.levels

    def draw(self, rng: np.random.Generator) -> Mask:
        """Return the (levels, height, width) mask of the free cells of a warehouse."""
        free = np.zeros((self.levels, self.height, self.width), np.bool_)
        free[:, 1:-1, 1:-1] = True
        top = 1
        while True:
            way, depth = (int(rng.integers(low, high + 1)) for low, high in (self.aisle, self.depth))
            if top + way + depth + self.aisle[0] > self.height - 1:
                return largest_part(free)
            top += way
            self._stack(rng, free[:-1, top : top + depth, 1 + self.aisle[1] : -1 - self.aisle[1]])
            top += depth

    def _stack(self, rng: np.random.Generator, rack: Mask) -> None:
        """Build a rack into its free cells (levels, depth, length): boards, uprights, and goods on some shelves."""
        rack[self.gap :: self.gap + 1] = False
        rack[:, :, :: self.bay + 1] = False
        for floor in range(0, len(rack), self.gap + 1):
            for left in range(1, rack.shape[2], self.bay + 1):
                if rng.random() < self.goods:
                    _load(rng, rack[floor : floor + self.gap, :, left : left + self.bay])


def _load(rng: np.random.Generator, shelf: Mask) -> None:
    """Put goods on a bay's shelf (levels, depth, width): a box of random sides that stands on the board."""
    tall, deep, across = (int(rng.integers(1, side + 1)) for side in shelf.shape)
    back, left = int(rng.integers(shelf.shape[1] - deep + 1)), int(rng.integers(shelf.shape[2] - across + 1))
    shelf[:tall, back : back + deep, left : left + across] = False
