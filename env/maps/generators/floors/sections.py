"""Rows of rooms along corridors, in sections: equal rooms, large and small ones, halls, lobbies, services, gaps."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.maps.generators.floors.site import OPEN, Side, Site, Spaces, depth_free
from indoor_explorers.env.maps.generators.floors.skeletons import Skeleton
from indoor_explorers.env.maps.generators.floors.style import SECTIONS, Style

#: A room is at least this wide and deep, in metres.
LEAST = 1.5
#: A row that leaves less than this share of its depth behind it takes all; one that leaves less than SHARED halves it.
THROUGH, SHARED = 1.5, 2.4


def fill(rng: np.random.Generator, site: Site, skeleton: Skeleton, style: Style) -> None:
    """Place rows of rooms along the sides of all corridors, and rooms at some of their ends."""
    sides, ends = [], []
    for corridor in skeleton.corridors:
        beside, at_ends = site.sides(corridor)
        ends += at_ends
        loaded = [rng.random() < style.loaded * corridor.loaded for _ in beside]
        if corridor.loaded == 1.0 and not any(loaded):
            loaded[0] = True
        sides += [side for side, has_rooms in zip(beside, loaded, strict=True) if has_rooms]
    for number in rng.permutation(len(sides)).tolist():
        _fill_side(rng, site, sides[number], style)
    for end in ends:
        if rng.random() < 0.6:
            _close_end(rng, site, end, style)


def _fill_side(rng: np.random.Generator, site: Site, side: Side, style: Style) -> None:
    """Fill one side of a corridor, wherever at least the smallest room fits."""
    view, start, stop = side
    wall = 1 + int(rng.random() < style.thick)
    depth = max(2, round(style.depth * rng.uniform(0.8, 1.25)))
    least = style.cells(LEAST, 2)
    low, high = max(start - style.module, 1), min(stop + style.module, view.shape[1] - 1)
    blocked = (view[: wall + least + 1, low:high] != 0).any(axis=0)
    blocked[: start - low - 1] |= rng.random() < 0.5  # some rows reach beyond the corridor's ends
    blocked[stop + 1 - low :] |= rng.random() < 0.5
    edges = np.flatnonzero(np.diff(np.concatenate([[True], blocked, [True]]).astype(np.int8)))
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        _fill_interval(rng, site, view, (low + first + 1, low + last - 1), wall, depth, style)


def _fill_interval(
    rng: np.random.Generator,
    site: Site,
    view: Spaces,
    interval: tuple[int, int],
    wall: int,
    depth: int,
    style: Style,
) -> None:
    """Fill columns of a side with sections, one after the other."""
    place, stop = interval
    least = style.cells(LEAST, 2)
    while stop - place >= least:
        kind = SECTIONS[int(rng.choice(len(SECTIONS), p=style.sections))]
        count = int(rng.integers(1, 7)) if kind in ("rooms", "small") else 1
        wide, deep = _size(rng, kind, depth, style)
        for _ in range(count):
            rest = stop - place
            width = rest if rest - wide < least + 2 else wide
            if width < least or width > 2.2 * wide + 2:
                break
            _place(rng, site, view, (place, place + width), wall, deep, kind, style)
            place += width + 1 + int(rng.random() < style.thick * 0.7)


def _size(rng: np.random.Generator, kind: str, depth: int, style: Style) -> tuple[int, int]:
    """Return the width and the depth of a room of a section."""
    if rng.random() < style.ragged_row:
        depth = round(depth * rng.uniform(0.6, 1.4))
    module = style.module * rng.uniform(0.85, 1.2)
    if kind == "hall":
        wide, deep = rng.uniform(9.0, 28.0), rng.uniform(9.0, 28.0)
        return style.cells(wide), style.cells(deep)
    factor = {"wide": rng.uniform(1.4, 2.6), "small": rng.uniform(0.45, 0.75)}.get(kind, 1.0)
    if kind in ("services", "nested"):
        module, depth = max(module, style.cells(rng.uniform(4.0, 9.0))), max(depth, style.cells(4.0))
    if kind == "stairs":
        module = style.cells(rng.uniform(2.5, 4.0))
    if kind == "gap":
        module = style.cells(rng.uniform(1.5, 6.0))
    if kind == "lobby":
        module, depth = style.cells(rng.uniform(3.0, 9.0)), round(depth * rng.uniform(0.4, 1.1))
    return max(style.cells(LEAST, 2), round(module * factor)), max(style.cells(LEAST, 2), depth)


def _place(
    rng: np.random.Generator,
    site: Site,
    view: Spaces,
    columns: tuple[int, int],
    wall: int,
    depth: int,
    kind: str,
    style: Style,
) -> None:
    """Place a room of a section where there is space; rows that face each other share what lies between them."""
    start, stop = columns
    free = depth_free(view, start, stop, wall, round(SHARED * depth) + 2)
    if kind == "gap" or free < style.cells(LEAST, 2):
        return
    if free < THROUGH * depth:
        depth = free if rng.random() < 0.8 else min(free, depth)
    elif free < SHARED * depth:
        depth = (free - 1) // 2
    if kind == "lobby":
        view[: wall + depth, start:stop] = OPEN
        return
    rows = slice(wall, wall + depth)
    room = view[rows, start:stop]
    if kind == "services":
        _divide(rng, site, room, style.cells(rng.uniform(1.8, 2.8), 2), style.cells(rng.uniform(3.5, 6.0), 3))
    elif kind == "nested":
        _divide(rng, site, room, style.cells(2.0, 2), max(style.cells(4.0, 3), round(max(room.shape) * 0.6)))
    else:
        room[:] = site.next_space()


def _divide(rng: np.random.Generator, site: Site, room: Spaces, least: int, most: int) -> None:
    """Divide a rectangle by walls at random until no part is longer than ``most`` cells, if ``least`` allows it."""
    tall, wide = room.shape
    longer = max(tall, wide)
    if longer <= most or longer < 2 * least + 1:
        room[:] = site.next_space()
        return
    lying = room if tall >= wide else room.T
    cut = int(rng.integers(least, longer - least))
    for part in (lying[:cut], lying[cut + 1 :]):
        _divide(rng, site, part, least, most)


def _close_end(rng: np.random.Generator, site: Site, side: Side, style: Style) -> None:
    """Place a vestibule, a room or a hall at the end of a corridor, if there is space."""
    view, start, stop = side
    kind = rng.random()
    aisle = stop - start
    if kind < 0.4:  # a vestibule or stairs, as wide as the corridor
        wide, deep = aisle, style.cells(rng.uniform(1.5, 4.0))
    elif kind < 0.75:
        wide, deep = round(style.module * rng.uniform(0.8, 2.0)), round(style.depth * rng.uniform(0.7, 1.6))
    else:
        wide, deep = style.cells(rng.uniform(9.0, 24.0)), style.cells(rng.uniform(8.0, 26.0))
    wide = max(wide, aisle)
    first = start - int(rng.integers(wide - aisle + 1))
    free = depth_free(view, first, first + wide, 1, deep)
    if free >= style.cells(LEAST, 2):
        view[1 : 1 + min(deep, free), first : first + wide] = site.next_space()


def fill_gaps(rng: np.random.Generator, site: Site, skeleton: Skeleton, style: Style) -> None:
    """Make rooms of what is left between the rooms of deep blocks."""
    least = style.cells(LEAST, 2)
    for top, left, tall, wide in skeleton.filled:
        area = np.s_[max(top, 1) : max(top + tall, 1), max(left, 1) : max(left + wide, 1)]
        part = site.spaces[area]
        if min(part.shape) < least + 2:
            continue
        free = _apart(part)
        for row, col in np.argwhere(free).tolist():
            if not free[row, col]:
                continue
            blocked = np.flatnonzero(~free[row, col:])
            width = int(blocked[0]) if len(blocked) else free.shape[1] - col
            down = np.flatnonzero(~free[row:, col : col + width].all(axis=1))
            height = int(down[0]) if len(down) else free.shape[0] - row
            if min(height, width) >= least and rng.random() < 0.9:
                _divide(rng, site, part[row : row + height, col : col + width], least, 3 * style.module)
            free[max(row - 1, 0) : row + height + 1, max(col - 1, 0) : col + width + 1] = False


def _apart(spaces: Spaces) -> np.ndarray:
    """Return the cells that are no space and have none beside them, and do not lie at the edge."""
    taken = np.pad(spaces != 0, 1, constant_values=True)
    rows = taken[:-2] | taken[1:-1] | taken[2:]
    return np.asarray(~(rows[:, :-2] | rows[:, 1:-1] | rows[:, 2:]))
