"""Geometry statistics of a floor plan, from its free cells alone: widths, rooms, doors, loops, furniture and walls.

A floor is cut into parts at its narrow places: free cells that no free square of more than ``passage`` cells a side
covers. A narrow place that touches two parts or more is a passage, as a door is; one that touches one part belongs to
it. A long one is a part of its own, as a narrow corridor is, unless it is open to another part over more than a
passage's width. Squares are the openings of granulometry (Matheron, Random Sets and Integral Geometry, 1975).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask

#: Widths are told apart up to this many cells.
WIDEST = 64
#: Narrow places of at least this many cells for each cell of a passage's width are long.
LONG = 4
#: A part is a corridor when it has at least this many times the cells of a square of its width.
SLENDER = 4.0
#: Solid pieces of at most this many cells are furniture.
FURNITURE = 12
#: A wall is straight where at least this many cells of it are in line.
STRAIGHT = 5

Labels = NDArray[np.integer[Any]]


class Statistic(NamedTuple):
    """What a statistic's values are, for tables and figures."""

    name: str
    unit: str
    logarithmic: bool
    """True for sizes, which are compared by their ratios."""


STATISTICS = (
    Statistic("floor", "free cells", True),
    Statistic("free share", "free cells / cells of the rectangle around them", False),
    Statistic("width", "cells, at every free cell", True),
    Statistic("corridor width", "cells, of long parts", True),
    Statistic("door width", "cells, of passages", False),
    Statistic("room", "cells of other parts", True),
    Statistic("loops", "loops a part", False),
    Statistic("dead ends", "share of parts with one passage", False),
    Statistic("furniture", "cells of small solid pieces / floor", False),
    Statistic("straight walls", "share in straight lines", False),
)


class Parts(NamedTuple):
    """A floor that was cut at its narrow places."""

    cells: NDArray[np.int64]
    """(n,) free cells of each part."""
    width: NDArray[np.int64]
    """(n,) the median width of each part's cells."""
    passages: NDArray[np.int64]
    """(m,) the width of each passage."""
    ways: NDArray[np.int64]
    """(k, 2) pairs of a passage and a part that it touches; places where two parts meet are passages as well."""

    @property
    def loops(self) -> int:
        """How many passages can be closed with everything still connected: the cycle rank of the graph of parts."""
        return len(self.ways) - len(self.cells) - len(self.passages) + 1

    @property
    def dead_ends(self) -> NDArray[np.bool_]:
        """(n,) True for parts with one passage."""
        return np.asarray(np.bincount(self.ways[:, 1], minlength=len(self.cells)) == 1)


def map_statistics(free: Mask, passage: int = 3) -> dict[str, NDArray[np.float64]]:
    """Return the values of each of :data:`STATISTICS` for a connected (H, W) floor; most have one value.

    ``passage`` is the width in cells up to which a place is narrow: 1.5 m in cells of 0.5 m.
    """
    rows, cols = np.flatnonzero(free.any(axis=1)), np.flatnonzero(free.any(axis=0))
    inner = np.pad(free[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1], 1)
    widths = local_widths(inner)
    parts = cut_into_parts(inner, widths, passage)
    long = parts.cells >= SLENDER * parts.width**2
    values = (
        [inner.sum()],
        [inner[1:-1, 1:-1].mean()],
        widths[inner],
        parts.width[long],
        parts.passages[parts.passages <= passage],
        parts.cells[~long],
        [parts.loops / len(parts.cells)],
        [parts.dead_ends.mean()],
        [furniture_share(inner)],
        [straight_share(inner)],
    )
    return {kind.name: np.asarray(found, np.float64) for kind, found in zip(STATISTICS, values, strict=True)}


def local_widths(free: Mask) -> NDArray[np.int64]:
    """Return (H, W): the side in cells of the largest free square that covers each free cell, 0 for solid cells."""
    from scipy import ndimage  # here, since it takes long to import

    widths = free.astype(np.int64)
    square = free.copy()  # True where the square of ``side`` cells that ends here, downwards and to the right, is free
    for side in range(2, WIDEST + 1):
        smaller, square = square, np.zeros_like(square)
        square[1:, 1:] = smaller[1:, 1:] & smaller[:-1, 1:] & smaller[1:, :-1] & smaller[:-1, :-1]
        if not square.any():
            break
        covered = square.astype(np.uint8)
        for axis in (0, 1):
            covered = ndimage.maximum_filter1d(covered, side, axis, mode="constant", origin=-(side // 2))
        widths[covered > 0] = side
    return widths


def cut_into_parts(free: Mask, widths: NDArray[np.int64], passage: int) -> Parts:
    """Cut a (H, W) floor with these :func:`local_widths` where it is at most ``passage`` cells wide."""
    from scipy import ndimage

    rooms, count = ndimage.label(free & (widths > passage))
    narrow, narrows = ndimage.label(free & (widths <= passage))
    touching = _touching(narrow, rooms)
    touched = np.bincount(touching[:, 0], minlength=narrows + 1)
    long = (np.bincount(narrow.ravel(), minlength=narrows + 1) >= LONG * passage) | (touched == 0)
    long[0] = False
    owner = np.zeros(narrows + 1, np.int64)  # the part that each narrow place is or belongs to; 0 for a passage
    niches = touching[(touched == 1)[touching[:, 0]]]
    owner[niches[:, 0]] = niches[:, 1]
    mouths = _mouths(np.where(long[narrow], narrow, 0), rooms)
    owner[long] = 0
    for place, room, _ in mouths[mouths[:, 2] > passage]:
        owner[place] = room
    corridors = np.flatnonzero(long & (owner == 0))
    owner[corridors] = count + 1 + np.arange(len(corridors))
    number = np.where(rooms > 0, rooms, owner[narrow])
    total = count + len(corridors)
    doors = np.flatnonzero(~long & (touched > 1))
    through = touching[np.isin(touching[:, 0], doors)]
    mouths = mouths[owner[mouths[:, 0]] != mouths[:, 1]]
    places = len(doors) + np.arange(len(mouths))
    ways = [
        np.stack([np.searchsorted(doors, through[:, 0]), through[:, 1]], axis=1),
        np.stack([places, owner[mouths[:, 0]]], axis=1),
        np.stack([places, mouths[:, 1]], axis=1),
    ]
    return Parts(
        cells=np.bincount(number.ravel(), minlength=total + 1)[1:],
        width=np.asarray(ndimage.median(widths, number, np.arange(1, total + 1)), np.int64).reshape(-1),
        passages=np.append(np.asarray(ndimage.maximum(widths, narrow, doors), np.int64).reshape(-1), mouths[:, 2]),
        ways=np.concatenate(ways) - [0, 1],
    )


def _touching(one: Labels, other: Labels) -> NDArray[np.int64]:
    """Return the (n, 2) pairs of labels above 0 of two maps whose cells are 4-neighbours somewhere."""
    found = []
    for first, second in ((one, other), (one.T, other.T)):
        for here, there in ((first[:-1], second[1:]), (first[1:], second[:-1])):
            meet = (here > 0) & (there > 0)
            found.append(np.stack([here[meet], there[meet]], axis=1))
    return np.unique(np.concatenate(found), axis=0).astype(np.int64)


def _mouths(long: Labels, rooms: Labels) -> NDArray[np.int64]:
    """Return (n, 3): a long narrow place, a room, and over how many cells they meet; once for each place of meeting."""
    from scipy import ndimage

    beside = (long > 0) & ndimage.binary_dilation(rooms > 0)
    mouths, count = ndimage.label(beside, np.ones((3, 3)))
    pairs = _touching(mouths, rooms)
    place = np.asarray(ndimage.maximum(long, mouths, np.arange(count + 1)), np.int64)
    sizes = np.bincount(mouths.ravel(), minlength=count + 1)
    return np.stack([place[pairs[:, 0]], pairs[:, 1], sizes[pairs[:, 0]]], axis=1)


def furniture_share(free: Mask) -> float:
    """Return the cells of small solid pieces as a share of the floor with them, (H, W) with solid cells around."""
    from scipy import ndimage

    pieces, _ = ndimage.label(~free, np.ones((3, 3)))
    sizes = np.bincount(pieces.ravel())[1:]
    small = int(sizes[sizes <= FURNITURE].sum())
    return small / (small + int(free.sum()))


def straight_share(free: Mask) -> float:
    """Return the share of the sides of cells between floor and wall that lie in line with others."""
    straight = total = 0
    for grid in (free, free.T):
        sides = grid[:-1].astype(np.int8) - grid[1:]
        lines = np.pad(sides, [(0, 0), (1, 1)]).ravel()
        ends = np.flatnonzero(np.diff(lines))
        runs = np.diff(ends)[lines[ends[:-1] + 1] != 0]
        straight += int(runs[runs >= STRAIGHT].sum())
        total += int(runs.sum())
    return straight / max(total, 1)
