"""Rooms and corridors: one room in each leaf of a random partition, corridors along the lines of the partition.

The partition is a binary one of the plane; see Shaker, Togelius and Nelson, Procedural Content Generation in Games
(2016), section 3.3. Rooms keep so far from the lines that a corridor on a line never cuts into a room: rooms are
entered by their doors alone.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.base import GeneratedMaps, check_room, check_sizes
from indoor_explorers.env.search.connected_parts import spanning_tree

#: The chance that a leaf is left as it is when it could be split and need not be.
WHOLE = 0.5
#: A room takes at least this share of each side of its leaf.
FILLED = 0.6


class Rectangle(NamedTuple):
    """Cells from (top, left) on."""

    top: int
    left: int
    tall: int
    wide: int

    def turned(self) -> Rectangle:
        """Swap rows and columns."""
        return Rectangle(self.left, self.top, self.wide, self.tall)


class RoomsMaps(GeneratedMaps):
    """Random rooms in solid rock, joined by corridors."""

    source: Literal["rooms"] = "rooms"
    room_size: tuple[int, int] = (5, 14)
    """Smallest and largest side of a room in cells."""
    corridor: int = Field(2, ge=1, le=64)
    """Cells from wall to wall of a corridor."""
    door: int = Field(1, ge=1, le=64)
    """Cells that a door is wide."""
    loops: float = Field(0.2, ge=0.0, le=1.0)
    """Share of neighbouring rooms that get a corridor of their own though there is another way."""

    @model_validator(mode="after")
    def _consistent(self) -> RoomsMaps:
        check_sizes("room_size", self.room_size)
        if not self.door <= self.corridor <= self.room_size[0]:
            raise ValueError(
                f"door, corridor and smallest room side are {self.door}, {self.corridor} and {self.room_size[0]}, "
                "expected each at most the next"
            )
        check_room("height", self.height, self.room_size[0] + 2, "the smallest room between two walls")
        check_room("width", self.width, self.room_size[0] + 2, "the smallest room between two walls")
        return self

    @property
    def gap(self) -> int:
        """Cells between a room and the edge of its leaf: half a corridor and a wall."""
        return (self.corridor + 1) // 2 + 1

    def draw(self, rng: np.random.Generator) -> Mask:
        """Return the (height, width) mask of rooms and corridors."""
        gap = self.gap
        shape = (self.height + 2 * (gap - 1), self.width + 2 * (gap - 1))  # what lies beyond a wall's width is cut
        leaves = partition(rng, shape, *(size + 2 * gap for size in self.room_size))
        rooms = [self._room(rng, leaf) for leaf in leaves]
        free = np.zeros(shape, np.bool_)
        for room in rooms:
            free[room.top : room.top + room.tall, room.left : room.left + room.wide] = True
        for one, other in self._joined(rng, leaves, rooms, shape):
            beside = leaves[other].left == leaves[one].left + leaves[one].wide
            if beside:
                self._carve(rng, free, leaves[other].left, rooms[one], rooms[other])
            else:
                self._carve(rng, free.T, leaves[other].top, rooms[one].turned(), rooms[other].turned())
        return free[gap - 1 : gap - 1 + self.height, gap - 1 : gap - 1 + self.width]

    def _room(self, rng: np.random.Generator, leaf: Rectangle) -> Rectangle:
        """Draw a room in a leaf."""
        smallest, largest = self.room_size
        sides, corner = [], []
        for start, side in ((leaf.top, leaf.tall), (leaf.left, leaf.wide)):
            space = side - 2 * self.gap
            longest = min(space, largest)
            sides.append(int(rng.integers(min(max(smallest, int(FILLED * space)), longest), longest + 1)))
            corner.append(start + self.gap + int(rng.integers(space - sides[-1] + 1)))
        return Rectangle(corner[0], corner[1], sides[0], sides[1])

    def _joined(
        self, rng: np.random.Generator, leaves: list[Rectangle], rooms: list[Rectangle], shape: tuple[int, int]
    ) -> NDArray[np.int64]:
        """Return (n, 2) pairs of rooms to join, the upper or left one first: a tree of short ways, and some loops."""
        pairs = neighbours(leaves, shape)
        if not len(pairs):
            return pairs
        corners = np.array(rooms)
        middles = corners[:, :2] + corners[:, 2:] / 2.0
        ways = np.abs(middles[pairs[:, 0]] - middles[pairs[:, 1]]).sum(axis=1) + rng.random(len(pairs))
        needed = spanning_tree(pairs, ways, len(rooms))
        return pairs[needed | (rng.random(len(pairs)) < self.loops)]

    def _carve(self, rng: np.random.Generator, free: Mask, line: int, one: Rectangle, other: Rectangle) -> None:
        """Join a room to one to its right, whose leaf begins in column ``line``: along it where they do not overlap."""
        wide, door, lane = self.corridor, self.door, line - self.corridor // 2
        low, high = max(one.top, other.top), min(one.top + one.tall, other.top + other.tall) - wide
        if low <= high:
            here = there = int(rng.integers(low, high + 1))
        else:
            here, there = (int(rng.integers(room.top, room.top + room.tall - wide + 1)) for room in (one, other))
        end = one.left + one.wide
        free[here : here + wide, end + 1 : lane + wide] = True
        free[there : there + wide, lane : other.left - 1] = True
        free[min(here, there) : max(here, there) + wide, lane : lane + wide] = True
        for row, col in ((here, end), (there, other.left - 1)):
            shift = int(rng.integers(wide - door + 1))
            free[row + shift : row + shift + door, col] = True


def partition(rng: np.random.Generator, shape: tuple[int, int], least: int, most: int) -> list[Rectangle]:
    """Split the plane at random until no side is longer than ``most``, where both halves have at least ``least``."""
    leaves, stack = [], [Rectangle(0, 0, *shape)]
    while stack:
        leaf = stack.pop()
        can = [leaf.tall >= 2 * least, leaf.wide >= 2 * least]
        must = leaf.tall > most or leaf.wide > most
        if not any(can) or (not must and rng.random() < WHOLE):
            leaves.append(leaf)
            continue
        turn = can[1] and not (can[0] and rng.random() * (leaf.tall + leaf.wide) < leaf.tall)
        whole = leaf.turned() if turn else leaf
        cut = int(rng.integers(least, whole.tall - least + 1))
        for part in (whole._replace(tall=cut), whole._replace(top=whole.top + cut, tall=whole.tall - cut)):
            stack.append(part.turned() if turn else part)
    return leaves


def neighbours(leaves: list[Rectangle], shape: tuple[int, int]) -> NDArray[np.int64]:
    """Return (n, 2) sorted pairs of leaves of a partition of ``shape`` that share an edge, upper or left one first."""
    owner = np.empty(shape, np.int64)
    for number, leaf in enumerate(leaves):
        owner[leaf.top : leaf.top + leaf.tall, leaf.left : leaf.left + leaf.wide] = number
    across = [(owner[:, :-1], owner[:, 1:]), (owner[:-1], owner[1:])]
    codes = [(one * len(leaves) + other)[one != other] for one, other in across]
    return np.stack(np.divmod(np.unique(np.concatenate(codes)), len(leaves)), axis=1)
