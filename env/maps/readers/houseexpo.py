"""Floor plans of HouseExpo (Li et al. 2019, arXiv 1903.09845): the outline of a house's floor as a polygon.

Format: https://github.com/TeaganLi/HouseExpo. Of its keys only ``verts`` is read, the corners (x, y) in metres.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.readers.opening import MAX_PIXELS, finite, kind, shown

#: Metres a cell where none are asked for.
RESOLUTION = 0.1
#: The outline is drawn in pixels of at most this many metres, and at least this many to a cell's side.
FINEST, FINER = 0.05, 3
#: The most corners a file may have; real ones have a hundred.
MAX_CORNERS = 2_000


def read_houseexpo(path: Path, data: Any, resolution: float) -> tuple[Belief, float]:
    """Draw the outline in a file's JSON ``data``; return (H, W) uint8 cells, 1 free or 2 occupied, and metres a pixel.

    x runs along the columns and y along the rows; what the outline encloses an odd number of times is free. Pixels
    are finer than the cells of ``resolution`` metres that they are for by a whole factor, and the outline begins at
    the edge of such a cell, one from the picture's edge.

    Raises :class:`InputError` with one line that says what is wrong with the file.
    """
    corners, extent = _placed(path, parse_houseexpo(path, data), resolution)
    finer = max(FINER, math.ceil(resolution / FINEST))
    metres = resolution / finer
    with np.errstate(over="ignore"):
        sides = extent / metres + 2 * finer + 1
    if not float(sides[0]) * float(sides[1]) <= MAX_PIXELS:
        raise InputError(
            f"{path}: expected an outline of at most {MAX_PIXELS:,} pixels, got {sides[1]:.3g} x {sides[0]:.3g} of "
            f"{metres:.3g} m; ask for a coarser --resolution, or correct verts (metres)"
        )
    image = Image.new("1", (int(sides[0]), int(sides[1])))
    ImageDraw.Draw(image).polygon([(float(x), float(y)) for x, y in np.rint(corners / metres) + finer], fill=1)
    return np.where(np.asarray(image), FREE, OCCUPIED).astype(np.uint8), metres


def _placed(path: Path, corners: NDArray[np.float64], resolution: float) -> tuple[NDArray[np.float64], Any]:
    """Move corners to the origin; return them and their (2,) extent in metres, some cells of ``resolution`` metres."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    with np.errstate(over="ignore"):
        extent = high - low
    if not extent.all():
        raise InputError(f"{path}: verts: expected an outline around some floor, got a straight line; correct it")
    if resolution > extent.min():
        raise InputError(
            f"{path}: expected cells smaller than the map, got {resolution:g} m a cell for a house of "
            f"{extent[1]:.3g} m x {extent[0]:.3g} m; ask for a finer --resolution, or correct verts (metres)"
        )
    with np.errstate(over="ignore"):
        return corners - low, extent


def parse_houseexpo(path: Path, data: Any) -> NDArray[np.float64]:
    """Return the (n, 2) corners of the outline in metres, x before y."""
    if not isinstance(data, dict) or "verts" not in data:
        got = f"the keys {', '.join(data)[:80]!r}" if isinstance(data, dict) and data else f"a JSON {kind(data)}"
        raise InputError(f"{path}: expected the key 'verts' (the outline's corners in metres), got {got}; add it")
    verts = data["verts"]
    if not isinstance(verts, list) or not 3 <= len(verts) <= MAX_CORNERS:
        got = f"{len(verts)}" if isinstance(verts, list) else f"a JSON {kind(verts)}"
        raise InputError(f"{path}: verts: expected 3 to {MAX_CORNERS} corners [x, y], got {got}; correct it")
    for number, corner in enumerate(verts):
        if not (isinstance(corner, list) and len(corner) == 2 and all(finite(part) for part in corner)):
            raise InputError(
                f"{path}: verts: expected corners [x, y] of two finite numbers, got {shown(corner)} "
                f"as number {number + 1}; correct it"
            )
    return np.array(verts, np.float64)
