"""Homes: rooms wall to wall, entered through one another.

A binary partition of the plane, as in :mod:`.rooms`, with a wall of one cell between rooms instead of corridors.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.base import GeneratedMaps, check_room, check_sizes
from indoor_explorers.env.maps.generators.furniture import furnish
from indoor_explorers.env.maps.generators.rooms import Rectangle, neighbours, partition
from indoor_explorers.env.search.connected_parts import spanning_tree


class HomesMaps(GeneratedMaps):
    """Random homes: rooms with doors between them, and no corridors but by chance."""

    source: Literal["homes"] = "homes"
    height: int = Field(32, ge=5, le=2048)
    """Cells."""
    width: int = Field(40, ge=5, le=2048)
    """Cells."""
    room_size: tuple[int, int] = (5, 13)
    """Smallest and largest side of a room in cells."""
    door: int = Field(2, ge=1, le=64)
    """Cells that a door is wide, where the wall is long enough."""
    loops: float = Field(0.15, ge=0.0, le=1.0)
    """Share of neighbouring rooms that get a door though there is another way."""
    wide: float = Field(0.2, ge=0.0, le=1.0)
    """Share of doors as wide as the wall, as between a kitchen and a living room."""
    furniture: float = Field(0.15, ge=0.0, le=0.5)
    """Share of the floor under furniture."""

    @model_validator(mode="after")
    def _consistent(self) -> HomesMaps:
        check_sizes("room_size", self.room_size)
        for name in ("height", "width"):
            check_room(name, getattr(self, name), self.room_size[0] + 2, "the smallest room between two walls")
        return self

    def draw(self, rng: np.random.Generator) -> Mask:
        """Return the (height, width) mask of rooms and doors, without the furniture's cells."""
        shape = (self.height - 1, self.width - 1)  # a room has its upper and its left wall
        smallest, largest = (size + 1 for size in self.room_size)
        leaves = partition(rng, shape, smallest, largest)
        free = np.zeros((self.height, self.width), np.bool_)
        for leaf in leaves:
            free[leaf.top + 1 : leaf.top + leaf.tall, leaf.left + 1 : leaf.left + leaf.wide] = True
        rooms = np.array([(leaf.top + 1, leaf.left + 1, leaf.tall - 1, leaf.wide - 1) for leaf in leaves], np.int64)
        pairs = [pair for pair in neighbours(leaves, shape).tolist() if _shared(leaves[pair[0]], leaves[pair[1]])]
        lengths = rng.random(len(pairs))
        needed = spanning_tree(np.array(pairs, np.int64).reshape(-1, 2), lengths, len(leaves))
        for (one, other), in_tree in zip(pairs, needed, strict=True):
            if in_tree or rng.random() < self.loops:
                self._open(rng, free, leaves[one], leaves[other])
        furnish(free, rooms, self.furniture, rng.integers(2**64, dtype=np.uint64))
        return free

    def _open(self, rng: np.random.Generator, free: Mask, one: Rectangle, other: Rectangle) -> None:
        """Open a door between a room and the one to its right or below it."""
        if other.left != one.left + one.wide:
            free, one, other = free.T, one.turned(), other.turned()
        shared = _shared(one, other)
        width = len(shared) if rng.random() < self.wide else min(self.door, len(shared))
        start = shared[int(rng.integers(len(shared) - width + 1))]
        free[start : start + width, other.left] = True


def _shared(one: Rectangle, other: Rectangle) -> range:
    """Return the rows, or the columns, in which a wall has both rooms beside it."""
    if other.left != one.left + one.wide:
        one, other = one.turned(), other.turned()
    return range(max(one.top, other.top) + 1, min(one.top + one.tall, other.top + other.tall))
