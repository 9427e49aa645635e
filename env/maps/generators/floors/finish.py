"""Post-processing of generated plans.

Fire doors, niches, a mirror axis, furniture, pillars, rotation by any angle, and uneven walls as SLAM maps have them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.generators.floors.doors import Door
from indoor_explorers.env.maps.generators.floors.site import OPEN, Site, Spaces
from indoor_explorers.env.maps.generators.floors.skeletons import Corridor
from indoor_explorers.env.maps.generators.floors.style import Style
from indoor_explorers.env.maps.generators.furniture import furnish, spares_the_way
from indoor_explorers.env.search.connected_parts import largest_part

#: Metres of corridor for each fire door, in buildings that have some.
BETWEEN_FIRE_DOORS = 25.0
#: Of ten pieces of wall in rooms, how many are niches; the others are half walls.
NICHES = 8
#: An axis of symmetry lies in this part of a plan's width.
AXIS = (0.5, 0.8)
#: Share of the rooms of a furnished building that have furniture.
FURNISHED = 0.7
#: Share of large rooms with pillars.
PILLARED = 0.07
#: A ragged map keeps at least this share of its floor.
KEPT = 0.85


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


def rooms_of(spaces: Spaces) -> NDArray[np.int64]:
    """Return (n, 4) top, left, height and width of all rooms."""
    from scipy import ndimage  # here, since it takes long to import

    found = filter(None, ndimage.find_objects(np.where(spaces > OPEN, spaces, 0)))
    sides = [(rows.start, cols.start, rows.stop - rows.start, cols.stop - cols.start) for rows, cols in found]
    return np.array(sides, np.int64).reshape(-1, 4)


def furnished(rng: np.random.Generator, free: Mask, rooms: NDArray[np.int64], style: Style) -> None:
    """Put furniture into most rooms (n, 4) of a furnished building and pillars into some large ones, in place."""
    chosen = rooms[rng.random(len(rooms)) < FURNISHED]
    key = rng.integers(2**64, dtype=np.uint64)
    if style.furnished > 0.0:
        furnish(free, chosen, style.furnished, key)
    large = rooms[:, 2:].min(axis=1, initial=10**6) >= style.cells(7.0)
    for room in rooms[large & (rng.random(len(rooms)) < PILLARED)].tolist():
        _set_pillars(rng, free, room, style)


def _set_pillars(rng: np.random.Generator, free: Mask, room: list[int], style: Style) -> None:
    """Set a lattice of pillars, one cell each, into a room."""
    top, left, tall, wide = room
    step = style.cells(rng.uniform(3.0, 6.0), 3)
    free[top + step - 1 : top + tall - 1 : step, left + step - 1 : left + wide - 1 : step] = False


def turned(free: Mask, made: list[Door], angle: float) -> Mask:
    """Return a plan turned by ``angle`` radians around its middle, as large as is needed; its doors stay open."""
    rows, cols = np.nonzero(free)
    middle = np.array([(rows.min() + rows.max()) / 2.0, (cols.min() + cols.max()) / 2.0])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    corners = (np.stack([rows, cols], axis=1) - middle) @ turn.T
    low = np.floor(corners.min(axis=0)) - 2.0
    shape = (np.ceil(corners.max(axis=0)) + 2.0 - low + 1.0).astype(np.int64)
    grid = np.stack(np.meshgrid(*(np.arange(side) for side in shape), indexing="ij"), axis=-1) + low
    back = np.rint(grid @ turn + middle).astype(np.int64)
    inside = ((back >= 0) & (back < free.shape)).all(axis=-1)
    back = np.clip(back, 0, np.array(free.shape) - 1)
    out = free[back[..., 0], back[..., 1]] & inside
    for door in made:
        _reopen(out, door, turn, middle, low)
    return np.asarray(out)


def _reopen(
    out: Mask, door: Door, turn: NDArray[np.float64], middle: NDArray[np.float64], low: NDArray[np.float64]
) -> None:
    """Make a path of 4-connected cells through a door of a plan that was turned."""
    half = np.array([(door.tall - 1) / 2.0, (door.wide - 1) / 2.0])
    centre = np.array([door.row, door.col]) + half
    way = np.zeros(2)
    way[door.axis] = half[door.axis] + 1.0
    ends = (np.stack([centre - way, centre + way]) - middle) @ turn.T - low
    line = np.linspace(ends[0], ends[1], 4 * int(np.ceil(2.0 * way.sum())) + 1)
    cells = np.rint(line).astype(np.int64)
    if (cells < 0).any() or (cells >= out.shape).any():  # a door of a part that was left out
        return
    out[cells[:, 0], cells[:, 1]] = True
    out[cells[:-1, 0], cells[1:, 1]] = True


def ragged(rng: np.random.Generator, free: Mask, amount: float) -> Mask:
    """Return a plan whose walls are uneven, by up to a cell: ``amount`` is the share of cells beside walls that close.

    Noise that is even over some cells decides, so that walls become thick in places; less of it where too much of the
    floor would be cut off.
    """
    from scipy import ndimage  # here, since it takes long to import

    noise = ndimage.gaussian_filter(rng.standard_normal(free.shape), 0.7)
    beside = free & ndimage.binary_dilation(~free)
    for share in (amount, amount / 2.0, amount / 4.0):
        closed = beside & (noise < np.quantile(noise, share))
        kept = largest_part(free & ~closed)
        if kept.sum() >= KEPT * free.sum():
            return kept
    return free
