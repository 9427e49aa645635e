"""Rows of rooms along corridors, in sections: equal rooms, large and small ones, halls, lobbies, services, gaps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.generators.floors.site import OPEN, Side, Site, Spaces, depth_free
from indoor_explorers.env.maps.generators.floors.skeletons import Skeleton
from indoor_explorers.env.maps.generators.floors.style import SECTIONS, Style

#: A room is at least this wide and deep, in metres.
LEAST = 1.5
#: A row takes all free depth below ``THROUGH`` times its own depth, and half of it below ``SHARED`` times.
THROUGH, SHARED = 1.5, 2.4
#: Share of corridors' ends with a room.
CLOSED = 0.6


class SectionRow(NamedTuple):
    """A row of rooms along one side of a corridor; lengths in cells."""

    view: Spaces
    """Spaces, whose first row lies beside the corridor."""
    wall: int
    """How thick the wall to the corridor is."""
    depth: int
    """The usual depth of its rooms."""


class Filling:
    """Places rooms along the corridors of a site."""

    def __init__(self, rng: np.random.Generator, site: Site, style: Style) -> None:
        self.rng = rng
        self.site = site
        self.style = style
        self.least = style.cells(LEAST, 2)

    def fill(self, skeleton: Skeleton) -> None:
        """Place rows of rooms along the sides of all corridors, rooms at some of their ends and in gaps of blocks."""
        sides, ends = [], []
        for corridor in skeleton.corridors:
            beside, at_ends = self.site.sides(corridor)
            ends += at_ends
            loaded = [self.rng.random() < self.style.loaded * corridor.loaded for _ in beside]
            if corridor.loaded == 1.0 and not any(loaded):
                loaded[0] = True
            sides += [side for side, has_rooms in zip(beside, loaded, strict=True) if has_rooms]
        for number in self.rng.permutation(len(sides)).tolist():
            self._fill_side(sides[number])
        for end in ends:
            if self.rng.random() < CLOSED:
                self._close_end(end)
        for block in skeleton.filled:
            self._fill_gaps(*block)

    def _fill_side(self, side: Side) -> None:
        """Fill one side of a corridor, wherever at least the smallest room fits."""
        view, start, stop = side
        row = SectionRow(
            view,
            wall=1 + int(self.rng.random() < self.style.thick),
            depth=max(2, round(self.style.depth * self.rng.uniform(0.8, 1.25))),
        )
        low, high = max(start - self.style.module, 1), min(stop + self.style.module, view.shape[1] - 1)
        blocked = (view[: row.wall + self.least + 1, low:high] != 0).any(axis=0)
        blocked[: start - low - 1] |= self.rng.random() < 0.5  # some rows reach beyond the corridor's ends
        blocked[stop + 1 - low :] |= self.rng.random() < 0.5
        edges = np.flatnonzero(np.diff(np.concatenate([[True], blocked, [True]]).astype(np.int8)))
        for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            self._fill_columns(row, low + first + 1, low + last - 1)

    def _fill_columns(self, row: SectionRow, start: int, stop: int) -> None:
        """Fill columns of a row with sections, one after the other."""
        while stop - start >= self.least:
            kind = SECTIONS[int(self.rng.choice(len(SECTIONS), p=self.style.sections))]
            count = int(self.rng.integers(1, 7)) if kind in ("rooms", "small") else 1
            wide, deep = self._size(kind, row.depth)
            for _ in range(count):
                rest = stop - start
                width = rest if rest - wide < self.least + 2 else wide
                if width < self.least or width > 2.2 * wide + 2:
                    break
                self._place(kind, row._replace(depth=deep), start, start + width)
                start += width + 1 + int(self.rng.random() < self.style.thick * 0.7)

    def _size(self, kind: str, depth: int) -> tuple[int, int]:
        """Return the width and the depth of a room of a section."""
        rng, cells = self.rng, self.style.cells
        if rng.random() < self.style.ragged_row:
            depth = round(depth * rng.uniform(0.6, 1.4))
        module = self.style.module * rng.uniform(0.85, 1.2)
        if kind == "hall":
            wide, deep = rng.uniform(9.0, 28.0), rng.uniform(9.0, 28.0)
            return cells(wide), cells(deep)
        factor = {"wide": rng.uniform(1.4, 2.6), "small": rng.uniform(0.45, 0.75)}.get(kind, 1.0)
        if kind in ("services", "nested"):
            module, depth = max(module, cells(rng.uniform(4.0, 9.0))), max(depth, cells(4.0))
        if kind == "stairs":
            module = cells(rng.uniform(2.5, 4.0))
        if kind == "gap":
            module = cells(rng.uniform(1.5, 6.0))
        if kind == "lobby":
            module, depth = cells(rng.uniform(3.0, 9.0)), round(depth * rng.uniform(0.4, 1.1))
        return max(self.least, round(module * factor)), max(self.least, depth)

    def _place(self, kind: str, row: SectionRow, start: int, stop: int) -> None:
        """Place a room of a section if there is space; rows that face each other share the space between them."""
        view, wall, depth = row
        free = depth_free(view, start, stop, wall, round(SHARED * depth) + 2)
        if kind == "gap" or free < self.least:
            return
        if free < THROUGH * depth:
            depth = free if self.rng.random() < 0.8 else min(free, depth)
        elif free < SHARED * depth:
            depth = (free - 1) // 2
        if kind == "lobby":
            view[: wall + depth, start:stop] = OPEN
            return
        room, cells = view[wall : wall + depth, start:stop], self.style.cells
        if kind == "services":
            self._divide(room, cells(self.rng.uniform(1.8, 2.8), 2), cells(self.rng.uniform(3.5, 6.0), 3))
        elif kind == "nested":
            self._divide(room, cells(2.0, 2), max(cells(4.0, 3), round(max(room.shape) * 0.6)))
        else:
            room[:] = self.site.next_space()

    def _divide(self, room: Spaces, least: int, most: int) -> None:
        """Divide a rectangle by walls at random until no part is longer than ``most``, if ``least`` cells allow it."""
        tall, wide = room.shape
        longer = max(tall, wide)
        if longer <= most or longer < 2 * least + 1:
            room[:] = self.site.next_space()
            return
        lying = room if tall >= wide else room.T
        cut = int(self.rng.integers(least, longer - least))
        for part in (lying[:cut], lying[cut + 1 :]):
            self._divide(part, least, most)

    def _close_end(self, side: Side) -> None:
        """Place a vestibule, a room or a hall at the end of a corridor, if there is space."""
        view, start, stop = side
        rng, style = self.rng, self.style
        kind, aisle = rng.random(), stop - start
        if kind < 0.4:  # a vestibule or stairs, as wide as the corridor
            wide, deep = aisle, style.cells(rng.uniform(1.5, 4.0))
        elif kind < 0.75:
            wide, deep = round(style.module * rng.uniform(0.8, 2.0)), round(style.depth * rng.uniform(0.7, 1.6))
        else:
            wide, deep = style.cells(rng.uniform(9.0, 24.0)), style.cells(rng.uniform(8.0, 26.0))
        wide = max(wide, aisle)
        first = start - int(rng.integers(wide - aisle + 1))
        free = depth_free(view, first, first + wide, 1, deep)
        if free >= self.least:
            view[1 : 1 + min(deep, free), first : first + wide] = self.site.next_space()

    def _fill_gaps(self, top: int, left: int, tall: int, wide: int) -> None:
        """Fill most gaps between the rooms of a deep block with rooms."""
        part = self.site.spaces[max(top, 1) : max(top + tall, 1), max(left, 1) : max(left + wide, 1)]
        if min(part.shape) < self.least + 2:
            return
        free = _apart(part)
        for row, col in np.argwhere(free).tolist():
            if not free[row, col]:
                continue
            width = _run(free[row, col:])
            height = _run(np.asarray(free[row:, col : col + width].all(axis=1)))
            if min(height, width) >= self.least and self.rng.random() < 0.9:
                self._divide(part[row : row + height, col : col + width], self.least, 3 * self.style.module)
            free[max(row - 1, 0) : row + height + 1, max(col - 1, 0) : col + width + 1] = False


def _run(line: Mask) -> int:
    """Return how many True values a line begins with."""
    return len(line) if line.all() else int(np.argmin(line))


def _apart(spaces: Spaces) -> Mask:
    """Return the cells that are no space and have none beside them, and do not lie at the edge."""
    taken = np.pad(spaces != 0, 1, constant_values=True)
    rows = taken[:-2] | taken[1:-1] | taken[2:]
    return np.asarray(~(rows[:, :-2] | rows[:, 1:-1] | rows[:, 2:]))
