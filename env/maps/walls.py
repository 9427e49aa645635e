"""The parts of a map that change in a building: doorways, straight walls and free-standing obstacles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED

#: Most cells across a doorway, and across a wall.
WIDEST, THICKEST = 3, 3
#: Fewest cells along a straight wall.
SHORTEST = 4
#: Most cells along each side of a free-standing obstacle.
LARGEST = 4


class Block(NamedTuple):
    """A rectangle of cells across which a wall runs, or a doorway leads."""

    top: int
    left: int
    height: int
    width: int
    upright: bool
    """Whether the wall runs along the columns; a doorway in such a wall leads along the rows."""

    @property
    def cells(self) -> tuple[slice, slice]:
        """Its rows and columns."""
        return slice(self.top, self.top + self.height), slice(self.left, self.left + self.width)

    @property
    def turned(self) -> Block:
        """The same rectangle in the transposed map."""
        return Block(self.left, self.top, self.width, self.height, not self.upright)


def standing_obstacles(truth: Belief) -> list[tuple[Mask, tuple[slice, ...]]]:
    """Return the free-standing obstacles of a map, each as a mask of its cells within some rows and columns.

    They are connected, corners included, touch neither a wall nor the map's border, and are small.
    """
    from scipy import ndimage  # here, since it takes long to import

    labels, _ = ndimage.label(truth == OCCUPIED, np.ones((3, 3)))
    found = []
    for number, box in enumerate(ndimage.find_objects(labels), start=1):
        small = all(part.stop - part.start <= LARGEST for part in box)
        inside = all(part.start > 0 and part.stop < side for part, side in zip(box, truth.shape, strict=True))
        if small and inside:
            found.append((labels[box] == number, box))
    return found


def walls_of(truth: Belief) -> Mask:
    """Return the (H, W) mask of the solid cells that belong to no free-standing obstacle."""
    walls = np.asarray(truth == OCCUPIED)
    for mask, box in standing_obstacles(truth):
        walls[box] &= ~mask
    return walls


def straight_walls(truth: Belief) -> list[Block]:
    """Return the straight walls of a map: at most ``THICKEST`` cells across with free cells on both sides."""
    return _level_walls(truth) + [block.turned for block in _level_walls(truth.T)]


def doorways(truth: Belief) -> list[Block]:
    """Return the doorways of a map: gaps of at most ``WIDEST`` cells in walls, with free cells on both sides."""
    return [block.turned for block in _upright_gaps(truth.T)] + _upright_gaps(truth)


def _level_walls(truth: Belief) -> list[Block]:
    """Return the straight walls that run along the rows."""
    walls, free = walls_of(truth), truth == FREE
    return [block for block in _bands(walls, free, THICKEST) if block.width >= SHORTEST]


def _upright_gaps(truth: Belief) -> list[Block]:
    """Return the doorways in walls that run along the columns."""
    walls, free = np.pad(walls_of(truth), 2), np.pad(truth == FREE, 2)
    bands = _bands(walls, free, WIDEST, swapped=True)
    return [
        band._replace(top=band.top - 2, left=band.left - 2, upright=True)
        for band in bands
        if band.width <= THICKEST and _opens(walls, free, band, -1) and _opens(walls, free, band, band.width)
    ]


def _opens(walls: Mask, free: Mask, band: Block, beyond: int) -> bool:
    """Tell whether a band of free cells between walls opens into a room at one end.

    A band ends where one of its walls ends. If it continues between walls one cell later and is longer than a cell, it
    is a corridor with a doorway at its side.
    """
    rows = slice(band.top, band.top + band.height)
    first, second = band.left + beyond, band.left + beyond + (1 if beyond > 0 else -1)
    between = free[rows, second].all() and walls[band.top - 1, second] and walls[band.top + band.height, second]
    return bool(free[rows, first].all() and not (between and band.width > 1))


def _bands(walls: Mask, free: Mask, most: int, *, swapped: bool = False) -> list[Block]:
    """Return the bands along the rows of up to ``most`` wall cells across that lie between free cells.

    ``swapped``: of free cells that lie between wall cells. Each is as long as can be.
    """
    inner, outer = (free, walls) if swapped else (walls, free)
    found = []
    for across in range(1, min(most, inner.shape[0] - 2) + 1):
        starts = outer[: -across - 1] & outer[across + 1 :]
        for row in range(1, across + 1):
            starts &= inner[row : row + starts.shape[0]]
        edges = np.diff(np.pad(starts.astype(np.int8), ((0, 0), (1, 1))), axis=1)
        tops, lefts = np.nonzero(edges == 1)
        ends = np.nonzero(edges == -1)[1]
        for top, left, end in zip(tops.tolist(), lefts.tolist(), ends.tolist(), strict=True):
            found.append(Block(top + 1, left, across, end - left, upright=False))
    return found
