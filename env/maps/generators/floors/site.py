"""The site of a floor: which space every cell belongs to, while rooms are placed along the corridors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.maps.generators.floors.skeletons import Corridor, Skeleton, moved, size_of

#: (H, W) int32: 0 wall or nothing yet, 1 corridors and what is open to them, from 2 on rooms, -1 the border.
Spaces = NDArray[np.int32]
BORDER, OPEN = -1, 1


class Side(NamedTuple):
    """The cells beside a rectangle."""

    view: Spaces
    """Spaces, whose first row is that beside the rectangle; writing to it writes to the site."""
    start: int
    """The columns where the rectangle begins and ends."""
    stop: int


class Site:
    """A (height, width) grid of spaces; rooms keep a wall around them."""

    def __init__(self, height: int, width: int) -> None:
        self.spaces: Spaces = np.zeros((height, width), np.int32)
        self.spaces[[0, -1]] = self.spaces[:, [0, -1]] = BORDER
        self._last = OPEN

    def next_space(self) -> int:
        """Return the number of a new room."""
        self._last += 1
        return self._last

    def lay(self, rng: np.random.Generator, skeleton: Skeleton, margin: int) -> Skeleton:
        """Place the corridors of a skeleton at random with a margin; return the placed skeleton."""
        height, width = self.spaces.shape
        top, left, tall, wide = size_of(skeleton)
        margin = min(margin, (height - tall) // 2, (width - wide) // 2)
        down = margin + int(rng.integers(height - tall - 2 * margin + 1)) - top
        right = margin + int(rng.integers(width - wide - 2 * margin + 1)) - left
        placed = moved(skeleton, down, right)
        for one in placed.corridors:
            self.spaces[one.top : one.top + one.tall, one.left : one.left + one.wide] = OPEN
        return placed

    def sides(self, corridor: Corridor) -> tuple[list[Side], list[Side]]:
        """Return the sides along a corridor and those at its ends; a hall has four sides and no ends."""
        top, left, tall, wide = corridor[:4]
        spaces, low, right = self.spaces, top + tall, left + wide
        rows = [Side(spaces[low:], left, right), Side(spaces[:top][::-1], left, right)]
        columns = [Side(spaces[:, right:].T, top, low), Side(spaces[:, :left][:, ::-1].T, top, low)]
        if max(tall, wide) <= 2 * min(tall, wide):
            return [*rows, *columns], []
        return (rows, columns) if wide > tall else (columns, rows)


def depth_free(view: Spaces, start: int, stop: int, wall: int, most: int) -> int:
    """Return how deep a room at columns ``start`` to ``stop`` behind a wall can be, with a wall around it."""
    if start < 1 or stop >= view.shape[1]:
        return 0
    block = view[: wall + most + 1, start - 1 : stop + 1] != 0
    taken = np.flatnonzero(block.any(axis=1))
    return int(taken[0]) - wall - 1 if len(taken) else min(most, view.shape[0] - wall - 1)
