"""Details of a plan: fire doors across corridors, niches and half walls in rooms, and an axis of symmetry."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.generators.floors.doors import Door
from indoor_explorers.env.maps.generators.floors.site import OPEN, Site, Spaces
from indoor_explorers.env.maps.generators.floors.skeletons import Corridor
from indoor_explorers.env.maps.generators.floors.style import Style
from indoor_explorers.env.maps.generators.furniture import spares_the_way

#: Metres of corridor for each fire door, in buildings that have some.
BETWEEN_FIRE_DOORS = 25.0
#: Of ten pieces of wall in rooms, how many are niches; the others are half walls.
NICHES = 8
#: An axis of symmetry lies in this part of a plan's width.
AXIS = (0.5, 0.8)


def set_fire_doors(rng: np.random.Generator, site: Site, corridors: list[Corridor], style: Style) -> None:
    """Put walls with an opening across corridors of some length, in place."""
    for corridor in corridors:
        top, left, tall, wide = corridor[:4]
        floor = site.spaces[top : top + tall, left : left + wide]
        lying = floor if wide > tall else floor.T
        aisle, long = lying.shape
        if not 3 <= aisle <= style.cells(6.0):
            continue
        for _ in range(int(rng.poisson(style.fire_doors * long / style.cells(BETWEEN_FIRE_DOORS)))):
            opening = min(style.cells(rng.uniform(1.0, 2.0)), aisle - 1)
            start = int(rng.integers(aisle - opening + 1))
            place = int(rng.integers(long))
            kept = lying[start : start + opening, place].copy()
            lying[:, place] = 0
            lying[start : start + opening, place] = kept


def set_niches(rng: np.random.Generator, free: Mask, rooms: np.ndarray, style: Style) -> None:
    """Build pieces of wall into some rooms (n, 4) of top, left, height and width, in place; all stays connected."""
    for top, left, tall, wide in rooms[rng.random(len(rooms)) < style.niches].tolist():
        if min(tall, wide) < 4:
            continue
        turn = bool(rng.random() < 0.5)
        grid, (row, col, deep, long) = (free.T, (left, top, wide, tall)) if turn else (free, (top, left, tall, wide))
        if rng.integers(10) < NICHES:
            height, width = 1 + int(rng.integers(2)), int(rng.integers(1, long // 2 + 1))
        else:
            height, width = int(rng.integers(1, deep // 2 + 1)), 1
        row += 0 if rng.random() < 0.5 else deep - height
        col += int(rng.integers(long - width + 1))
        if rng.random() < 0.5:
            col = (left if not turn else top) + (0 if rng.random() < 0.5 else long - width)
        if grid[row : row + height, col : col + width].all() and spares_the_way(grid, row, col, height, width):
            grid[row : row + height, col : col + width] = False


def mirrored(
    rng: np.random.Generator, free: Mask, spaces: Spaces, made: list[Door], most: int
) -> tuple[Mask, Spaces, list[Door]]:
    """Return a plan with an axis of symmetry across one of its corridors, at most ``most`` columns wide.

    Where there is no such axis, the plan is returned as it is.
    """
    cols = np.flatnonzero(free.any(axis=0))
    first, last = int(cols[0]), min(int(cols[-1]), int(cols[0]) + most // 2 - 1)
    low, high = (first + round(share * (cols[-1] - first)) for share in AXIS)
    axes = np.flatnonzero((spaces[:, low : min(high, last) + 1] == OPEN).any(axis=0))
    if not len(axes):
        return free, spaces, made
    axis = low + int(axes[int(rng.integers(len(axes)))])
    half = spaces[:, : axis + 1]
    other = np.where(half > OPEN, half + spaces.max(), half)[:, -2::-1]
    doors = [door for door in made if door.col + door.wide <= axis + 1]
    doors += [door._replace(col=2 * axis - door.col - door.wide + 1) for door in doors]
    free = np.concatenate([free[:, : axis + 1], free[:, :axis][:, ::-1]], axis=1)
    return free, np.concatenate([half, other], axis=1), doors
