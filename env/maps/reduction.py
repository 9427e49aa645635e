"""Turn a source's pixels into the cells of a map, coarser by any factor, with doors open and walls closed.

Cells outside of the largest connected free part can never be explored, so they become solid. Floor plans converted to
occupancy maps often contain only each room's outline, and the space between two outlines is unknown even in a doorway:
:func:`open_doorways` opens these.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.floorplan import MAX_CELLS, Floorplan
from indoor_explorers.env.search.connected_parts import connected_parts, extent, largest_part

if TYPE_CHECKING:
    from scipy import sparse

#: A doorway is at most this deep, in metres: the thickness of a wall.
DEPTH = 1.2
#: A doorway leads into a room of at least this size, in square metres; smaller free areas are sensor noise.
ROOM = 1.0
#: Thresholds of the occupied share that makes a cell solid, in the order of trial; 0 means any occupied pixel.
THRESHOLDS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5)
#: A threshold is good enough if this share of the source's connected floor stays connected.
ENOUGH = 0.95
#: A cell is free only when at least this share of it is.
FREE_SHARE = 0.5

_STRIP = 64
_SLACK = 1e-9


@dataclass(frozen=True, eq=False, kw_only=True)
class Source:
    """The pixels of a map and their description."""

    name: str
    """Names the map in tables."""
    where: str
    """Names the file in errors."""
    cells: Belief
    """(H, W) uint8: 0 unknown, 1 free, 2 occupied."""
    resolution: float
    """Metres a pixel."""
    start: Cell | None = None
    """The pixel (row, column) that marks where to start, if any."""


def reduced(source: Source, resolution: float | None) -> Floorplan:
    """Turn a source into a floor plan with cells of ``resolution`` metres; None keeps the source's pixels.

    Only the largest connected free part stays free; unknown pixels count as solid. A cell is solid when the occupied
    share of its area reaches a threshold, or when less than half of it is connected floor. The threshold is the first
    of :data:`THRESHOLDS` that keeps :data:`ENOUGH` of the floor connected, else the one that keeps most: a small one
    keeps thin walls closed, a larger one keeps doors open. ``Floorplan.kept`` is the share of the source's free area in
    reachable cells and in the solid cells beside them. The start becomes the nearest free cell.

    Raises :class:`InputError` when the resolution is finer than the source's, or so coarse that no floor is left.
    """
    factor = checked_factor(source.where, source.cells.shape, source.resolution, resolution)
    all_free = source.cells == FREE
    main = largest_part(all_free)
    if not main.any():
        raise InputError(
            f"{source.where}: expected a map with free pixels, got none; check its values, or thresholds and negate"
        )
    share = float(main.sum() / all_free.sum())
    if factor == 1.0:
        plan = Floorplan.from_free(main, source.name, source.resolution, share, settled(source.start, main))
        return replace(plan, connected=share)
    free, connected = best_threshold(area_share(source.cells == OCCUPIED, factor), area_share(main, factor))
    if not free.any():
        raise InputError(
            f"{source.where}: expected some floor left, got none at a resolution of {resolution:g} m; "
            f"ask for a finer one (the source has {source.resolution:g} m)"
        )
    start = settled(source.start, free, factor=factor)
    return replace(Floorplan.from_free(free, source.name, resolution, share * connected, start), connected=share)


def settled(start: Cell | None, free: Mask, factor: float = 1.0) -> Cell | None:
    """Return the free cell nearest to the one that a start pixel lies in; ``factor`` is pixels a cell.

    Of several the uppermost counts, then the leftmost; None stays None.
    """
    if start is None:
        return None
    cell = np.minimum(np.array(start) // factor, np.array(free.shape) - 1).astype(np.int64)
    cells = np.argwhere(free)
    row, col = cells[int(np.argmin(((cells - cell) ** 2).sum(axis=1)))]
    return int(row), int(col)


def checked_factor(where: str, shape: tuple[int, ...], metres: float, resolution: float | None) -> float:
    """Return pixels a cell along each side, at least 1 and enough for :data:`MAX_CELLS`; whole numbers are exact.

    A reader that knows the (H, W) ``shape`` and the ``metres`` a pixel from a header calls it before decoding the rest.

    Raises :class:`InputError` when cells of ``resolution`` metres, None for one a pixel, are too many, too fine or too
    coarse; ``where`` names the file.
    """
    height, width = shape
    if resolution is None:
        check_cells(where, height, width)
        return 1.0
    check_resolution(where, resolution)
    if max(shape) > MAX_CELLS:
        raise InputError(
            f"{where}: expected at most {MAX_CELLS:,} pixels along a side, got {height:,} x {width:,}; cut it to size"
        )
    factor = resolution / metres
    factor = round(factor) if abs(factor - round(factor)) < 1e-6 * factor else factor
    if factor < 1.0:
        raise InputError(
            f"{where}: expected a resolution of at least the source's {metres:g} m, "
            f"got {resolution:g} m; ask for that or coarser"
        )
    if factor > max(shape):
        raise InputError(
            f"{where}: expected cells smaller than the map, got {resolution:g} m a cell; ask for a finer "
            f"--resolution (the source has {metres:g} m)"
        )
    check_cells(where, math.ceil(height / factor - _SLACK), math.ceil(width / factor - _SLACK))
    return float(factor)


def check_cells(where: str, height: int, width: int) -> None:
    """Raise :class:`InputError` when a map would have more than :data:`MAX_CELLS` cells."""
    if height * width > MAX_CELLS:
        raise InputError(
            f"{where}: expected at most {MAX_CELLS:,} cells, got {height:,} x {width:,}; ask for a coarser --resolution"
        )


def check_resolution(where: str, resolution: float) -> None:
    """Raise :class:`InputError` unless a resolution in metres is a number above 0; ``where`` names the file."""
    if not (math.isfinite(resolution) and resolution > 0.0):
        raise InputError(f"{where}: expected a resolution above 0 m, got {resolution}; correct it")


def best_threshold(occupied: NDArray[np.float64], floor: NDArray[np.float64]) -> tuple[Mask, float]:
    """Return the free cells of the first threshold that is good enough, or of the best, and the share that it keeps."""
    results = []
    for threshold in THRESHOLDS:
        solid = occupied >= threshold - _SLACK if threshold else occupied > _SLACK
        results.append(_connected(~solid & (floor >= FREE_SHARE - _SLACK), floor))
        if results[-1][1] >= ENOUGH:
            return results[-1]
    return max(results, key=lambda result: result[1])


def _connected(free: Mask, floor: NDArray[np.float64]) -> tuple[Mask, float]:
    """Return the largest connected part of the free cells, and the share of the floor in it or right beside it."""
    from scipy import ndimage  # here, since it takes long to import

    part = largest_part(free)
    beside = ndimage.binary_dilation(part, np.ones((3, 3), np.bool_)) & ~free
    return part, float(floor[part | beside].sum() / floor.sum())


def area_share(mask: Mask, factor: float) -> NDArray[np.float64]:
    """Return the share of each cell's area that is True in ``mask``.

    A (H, W) bool mask becomes (ceil(H / factor), ceil(W / factor)) float64; cells start at the upper left
    corner, a pixel across a border counts to both sides by area, and what lies beyond the mask is False.
    """
    down, across = _overlaps(mask.shape[0], factor), _overlaps(mask.shape[1], factor).T
    strips = []
    for start in range(0, down.shape[0], _STRIP):
        stop = min(start + _STRIP, down.shape[0])
        low, high = int(start * factor), min(math.ceil(stop * factor), mask.shape[0])
        strips.append(np.asarray(down[start:stop, low:high] @ (mask[low:high].astype(np.float64) @ across)))
    return np.vstack(strips)


def _overlaps(pixels: int, factor: float) -> sparse.csr_array[np.float64]:
    """Return the (cells, pixels) matrix of how much of each cell's length each pixel covers."""
    from scipy import sparse  # here, since it takes long to import

    cells = math.ceil(pixels / factor - _SLACK)
    borders = np.minimum(np.arange(cells + 1) * factor, pixels)
    cuts = np.unique(np.concatenate([np.arange(pixels + 1, dtype=np.float64), borders]))
    middles = (cuts[1:] + cuts[:-1]) / 2.0
    cell = np.minimum(middles / factor, cells - 1).astype(np.int64)
    return sparse.csr_array((np.diff(cuts) / factor, (cell, middles.astype(np.int64))), shape=(cells, pixels))


def cropped(plan: Floorplan) -> Floorplan:
    """Cut a floor plan to its free cells and one solid cell on each side, left out where it makes too large a map."""
    free = plan.truth == FREE
    rows, cols = extent(free)
    inner = free[rows, cols]
    walled = np.pad(inner, 1)
    wall = int(walled.size <= MAX_CELLS)
    start = None if plan.start is None else (plan.start[0] - rows.start + wall, plan.start[1] - cols.start + wall)
    return replace(plan, truth=np.where(walled if wall else inner, FREE, OCCUPIED).astype(np.uint8), start=start)


def open_doorways(cells: Belief, resolution: float) -> Belief:
    """Return (H, W) uint8 ``cells`` with doorways free; ``resolution`` is metres a pixel.

    A doorway is a straight strip of unknown pixels, along a row or a column and at most :data:`DEPTH` long, between the
    free floors of two rooms that are not connected otherwise.
    """
    labels, sizes = connected_parts(cells == FREE)
    rooms = sizes * resolution**2 >= ROOM
    rooms[0] = False
    if rooms.sum() < 2 or not (cells == UNKNOWN).any():
        return cells
    room = np.where(rooms[labels], labels, 0).astype(np.int32)
    depth = int(DEPTH / resolution + 1e-9)
    found = _strips(cells, room, depth) | _strips(cells.T, room.T, depth).T
    return np.where(found, FREE, cells)


def _strips(cells: Belief, room: NDArray[np.int32], depth: int) -> NDArray[np.bool_]:
    """Mark the unknown pixels between two rooms of a row that are at most ``depth`` pixels apart."""
    known = cells != UNKNOWN
    before = _nearest_before(known)
    after = cells.shape[1] - 1 - _nearest_before(known[:, ::-1])[:, ::-1]
    inside = ~known & (before >= 0) & (after < cells.shape[1]) & (after - before <= depth + 1)
    rows, cols = np.nonzero(inside)
    left, right = room[rows, before[rows, cols]], room[rows, after[rows, cols]]
    joins = (left > 0) & (right > 0) & (left != right)
    marked = np.zeros(cells.shape, np.bool_)
    marked[rows[joins], cols[joins]] = True
    return marked


def _nearest_before(known: NDArray[Any]) -> NDArray[np.int32]:
    """Return for each pixel the column of the last known pixel at or before it in its row, -1 where none is."""
    columns = np.arange(known.shape[1], dtype=np.int32)
    return np.maximum.accumulate(np.where(known, columns, np.int32(-1)), axis=1)
