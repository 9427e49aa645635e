"""Draw the storeys of a building, and stack them to a volume with slabs between."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.readers.rmf import STOREY, BuildingSettings, Points, Storey, chosen, parse_rmf
from indoor_explorers.env.maps.readers.sheet import PIXEL, Sheet, within
from indoor_explorers.env.maps.reduction import (
    area_share,
    best_threshold,
    check_cells,
    checked_factor,
    open_doorways,
)
from indoor_explorers.env.search.connected_parts import connected_parts

#: Metres a cell where none are asked for, and metres around the walls.
RESOLUTION, MARGIN = 0.5, 1.0
#: Floors of fewer square metres are gaps in a drawing.
LEAST = 1.0


class Drawing(NamedTuple):
    """A storey in pixels of 0.1 m."""

    cells: Belief
    """(H, W) uint8: 0 unknown, 1 free, 2 occupied; doors are open."""
    doors: Mask
    """(H, W) below lintels."""
    openings: Mask
    """(H, W) openings in the floor: shafts of lifts, and holes."""


def draw_storey(path: Path, settings: BuildingSettings, resolution: float | None) -> Belief:
    """Return the (H, W) uint8 cells of the one storey that ``settings`` name, in pixels of 0.1 m."""
    storey = chosen(path, parse_rmf(path), str(settings.storey))
    sheet = _sheet(path, [storey])
    checked_factor(str(path), sheet.shape, PIXEL, resolution)
    return _drawn(sheet, storey).cells


def stack_storeys(path: Path, settings: BuildingSettings, resolution: float | None) -> tuple[Belief, float]:
    """Return the (L, H, W) uint8 cells, 1 free or 2 occupied, of a building's storeys, and metres a cell.

    The levels of a storey reach from its floor to its ceiling, with walls all the way up and doors as high as
    ``settings`` say; above all but the last is a slab of one level. In it are openings where lifts pass, and where the
    storey above has holes in its floor.
    """
    storeys, metres = parse_rmf(path), RESOLUTION if resolution is None else resolution
    sheet = _sheet(path, storeys)
    factor = checked_factor(str(path), sheet.shape, PIXEL, metres)
    heights = [max(2, round(height / metres)) for height in _heights(storeys, settings.storey_height)]
    rows, cols = (-(-side // factor) for side in sheet.shape)
    check_cells(str(path), int((rows + 1) * sum(heights)), int(cols))
    levels: list[Mask] = []
    for storey, height in zip(storeys, heights, strict=True):
        drawing = _drawn(sheet, storey)
        open_below = _reduced(drawing.cells, factor)
        if levels:  # the slab below
            levels.append(levels[-1] & open_below & (area_share(drawing.openings, factor) >= 0.5))
        closed_above = open_below & ~(area_share(drawing.doors, factor) > 0.0)
        doors = min(height - 1, max(1, round(settings.door_height / metres)))
        levels += [open_below] * doors + [closed_above] * (height - 1 - doors)
    return np.where(np.stack(levels), np.uint8(FREE), np.uint8(OCCUPIED)), metres


def _heights(storeys: list[Storey], asked: float) -> list[float]:
    """Return the metres from the floor of each storey to the next; the last one is as high as the one below."""
    if asked > 0.0:
        return [asked] * len(storeys)
    found = np.maximum(np.diff([storey.elevation for storey in storeys]), 0.0).tolist()
    return [*found, found[-1] if found else STOREY]


def _sheet(path: Path, storeys: Iterable[Storey]) -> Sheet:
    points = [np.concatenate([s.walls.ravel(), s.doors.ravel(), *s.floors, *s.shafts]) for s in storeys]
    return Sheet.around(path, _pairs(np.concatenate(points)), MARGIN)


def _pairs(points: Points) -> NDArray[np.float64]:
    """Return places as (..., 2) x and y."""
    return np.stack([points.real, points.imag], axis=-1)


def _drawn(sheet: Sheet, storey: Storey) -> Drawing:
    """Draw a storey: walls on floors, then doors, then the shafts of lifts with walls and doors of their own."""
    walls, doors = (sheet.lines(_pairs(lines)) for lines in (storey.walls, storey.doors))
    shafts, gates, holes, floors = (
        sheet.areas(map(_pairs, outlines)) for outlines in (storey.shafts, storey.gates, storey.holes, storey.floors)
    )
    cells = np.where(within(floors, 1) | within(doors, 2), np.uint8(FREE), np.uint8(UNKNOWN))
    cells[walls] = OCCUPIED
    cells[doors] = FREE
    cells[within(shafts, 1)] = OCCUPIED
    cells[shafts | gates] = FREE
    return Drawing(open_doorways(cells, PIXEL), doors, shafts | holes)


def _reduced(cells: Belief, factor: float) -> Mask:
    """Return the (H', W') free cells of a drawing; parts that are not connected stay so, and doors open."""
    from scipy import ndimage  # here, since it takes long to import

    occupied = area_share(cells == OCCUPIED, factor)
    labels, sizes = connected_parts(cells == FREE)
    free = np.zeros(occupied.shape, np.bool_)
    for part in np.argsort(-sizes[1:], kind="stable") + 1:
        if sizes[part] * PIXEL**2 >= LEAST:
            found, _ = best_threshold(occupied, area_share(labels == part, factor))
            free |= found & ~ndimage.binary_dilation(free)
    return free
