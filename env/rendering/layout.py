"""The layout of a picture: a caption, the team's map, and a panel for each UAV's own map beside or below.

A layout depends on the size of the map and of the team alone, so every frame of an episode has the same size.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from math import ceil
from typing import NamedTuple

#: Pixels of the longer side of the team's map: at least, as far as whole cells allow, and at most.
LEAST, MOST = 576, 1200
#: The most pixels of a cell.
CELL = 64
#: Pixels around the picture, between panels, of the caption, of a panel's title, and of the line below.
MARGIN, GAP, CAPTION, TITLE, FOOTER = 16, 14, 46, 22, 24
#: The most that a cell of a panel may measure of one of the team's map.
LARGEST_PANEL = 0.6
#: The least width of a picture, so that its caption can be read.
NARROWEST = 480
#: The most panels; the other UAVs are drawn on the team's map alone.
PANELS = 16


class Box(NamedTuple):
    """A rectangle of pixels."""

    top: int
    left: int
    height: int
    width: int


class FrameLayout(NamedTuple):
    """The places of a picture's parts."""

    height: int
    """Of the whole picture, in pixels."""
    width: int
    main: Box
    """The team's map."""
    panels: tuple[Box, ...]
    """The own maps of the first UAVs, each with its title in the ``TITLE`` pixels above it."""
    missing: int
    """UAVs without a panel."""


class _Grid(NamedTuple):
    """Panels in rows and columns beside or below the team's map."""

    beside: bool
    rows: int
    cols: int
    cell: float
    score: float


@lru_cache(maxsize=32)
def layout_of(shape: tuple[int, int], team: int) -> FrameLayout:
    """Return the layout for a map of (H, W) cells and a team; a lone UAV has no panel, its map is the team's."""
    size = _main_size(shape)
    count = min(team, PANELS) if team > 1 else 0
    top = MARGIN + CAPTION
    if not count:
        return _framed(Box(top, MARGIN, *size), (), 0)
    grid = max(_grids(shape, size, count), key=lambda grid: grid.score)
    main = Box(top, MARGIN, *size)
    return _framed(main, tuple(_panels(main, shape, grid, count)), team - count)


def cell_size(pixels: float) -> float:
    """Return the pixels of a cell: whole ones where cells are large, so that all look the same."""
    return float(int(pixels)) if pixels >= 8 else pixels


def _main_size(shape: tuple[int, int]) -> tuple[int, int]:
    longer = max(shape)
    cell = min(ceil(LEAST / longer), CELL) if longer <= MOST else MOST / longer
    return max(round(shape[0] * cell), 1), max(round(shape[1] * cell), 1)


def _grids(shape: tuple[int, int], size: tuple[int, int], count: int) -> Iterator[_Grid]:
    """Yield the ways to arrange ``count`` panels, scored by how large they are and how well they fill a page."""
    (tall, wide), (height, width) = shape, size
    for rows, cols in {(rows, ceil(count / rows)) for rows in range(1, count + 1)}:
        down = (height - (rows - 1) * GAP - rows * TITLE) / (rows * tall)
        across = (width - (cols - 1) * GAP) / (cols * wide)
        for beside, room in ((True, down), (False, across)):
            cell = cell_size(min(room, LARGEST_PANEL * height / tall))
            if cell > 0 and rows * cols - count < min(rows, cols):
                used = cell / room
                high, broad = rows * (tall * cell + TITLE), cols * wide * cell
                whole = (height, width + broad) if beside else (height + high, width)
                lopsided = max(1.0, whole[1] / whole[0] / 1.9, whole[0] / whole[1] / 1.1)
                yield _Grid(beside, rows, cols, cell, cell * used * (count / (rows * cols)) ** 2 / lopsided**2)


def _panels(main: Box, shape: tuple[int, int], grid: _Grid, count: int) -> Iterator[Box]:
    """Yield the panels row by row; a grid beside the map is as high as it, one below as wide."""
    height, width = max(round(shape[0] * grid.cell), 1), max(round(shape[1] * grid.cell), 1)
    down, across = height + TITLE + GAP, width + GAP
    top, left = main.top + TITLE, main.left + main.width + 2 * GAP
    if grid.beside and grid.rows > 1:
        down = (main.height - TITLE - height) // (grid.rows - 1)
    if not grid.beside:
        top, left = main.top + main.height + GAP + TITLE, main.left
        across = (main.width - width) // (grid.cols - 1) if grid.cols > 1 else across
    for number in range(count):
        row, col = divmod(number, grid.cols)
        yield Box(top + row * down, left + col * across, height, width)


def _framed(main: Box, panels: tuple[Box, ...], missing: int) -> FrameLayout:
    """Add margins, and centre a picture that is narrower than a caption."""
    boxes = (main, *panels)
    width = max(box.left + box.width for box in boxes) + MARGIN
    height = max(box.top + box.height for box in boxes) + (FOOTER if missing else 0) + MARGIN
    shift = max(0, NARROWEST - width) // 2
    main, *rest = (box._replace(left=box.left + shift) for box in boxes)
    return FrameLayout(height, max(width, NARROWEST), main, tuple(rest), missing)
