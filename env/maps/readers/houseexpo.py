"""Floor plans of HouseExpo (Li et al. 2019, arXiv 1903.09845): the outline of a house's floor as a polygon.

Format: https://github.com/TeaganLi/HouseExpo. Of its keys only ``verts`` is read, the corners (x, y) in metres.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.readers.image import MAX_PIXELS
from indoor_explorers.env.maps.readers.opening import one_line, read_bytes

#: Metres a cell where none are asked for.
RESOLUTION = 0.1
#: The outline is drawn in pixels of at most this many metres, and at least this many to a cell's side.
FINEST, FINER = 0.05, 3
#: The most bytes and corners a file may have; real ones have some thousand bytes and a hundred corners.
MAX_BYTES, MAX_CORNERS = 4_000_000, 2_000


def read_houseexpo(path: Path, resolution: float) -> tuple[Belief, float]:
    """Draw a HouseExpo ``.json`` file; return (H, W) uint8 cells, 1 free or 2 occupied, and metres a pixel.

    x runs along the columns and y along the rows; what the outline encloses an odd number of times is free. Pixels
    are finer than the cells of ``resolution`` metres that they are for by a whole factor, and the outline begins at
    the edge of such a cell, one from the picture's edge.

    Raises :class:`InputError` with one line that says what is wrong with the file.
    """
    corners, extent = _placed(path, parse_houseexpo(path), resolution)
    finer = max(FINER, math.ceil(resolution / FINEST))
    metres = resolution / finer
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


def parse_houseexpo(path: Path) -> NDArray[np.float64]:
    """Return the (n, 2) corners of the outline in metres, x before y."""
    text = read_bytes(path, MAX_BYTES, "a HouseExpo file")
    try:
        data = json.loads(text, parse_int=float)  # of any number of digits, in time that grows with them alone
    except RecursionError as error:
        raise InputError(f"{path}: expected a HouseExpo file, got JSON nested too deeply; is it one?") from error
    except ValueError as error:
        raise InputError(f"{path}: expected JSON, got {one_line(error)}; correct it") from error
    if not isinstance(data, dict) or "verts" not in data:
        got = f"the keys {', '.join(data)[:80]}" if isinstance(data, dict) and data else f"a JSON {_kind(data)}"
        raise InputError(f"{path}: expected the key 'verts' (the outline's corners in metres), got {got}; add it")
    verts = data["verts"]
    if not isinstance(verts, list) or not 3 <= len(verts) <= MAX_CORNERS:
        got = f"{len(verts)}" if isinstance(verts, list) else f"a JSON {_kind(verts)}"
        raise InputError(f"{path}: verts: expected 3 to {MAX_CORNERS} corners [x, y], got {got}; correct it")
    for number, corner in enumerate(verts):
        if not (isinstance(corner, list) and len(corner) == 2 and all(_finite(part) for part in corner)):
            raise InputError(
                f"{path}: verts: expected corners [x, y] of two finite numbers, got {one_line_of(corner)} "
                f"as number {number + 1}; correct it"
            )
    return np.array(verts, np.float64)


def one_line_of(value: Any) -> str:
    """Return a JSON value in a few characters."""
    if isinstance(value, list):
        return f"a list of {len(value)}" if len(value) != 2 else f"[{', '.join(one_line_of(part) for part in value)}]"
    return repr(value)[:30] if isinstance(value, float | str | bool) else f"a JSON {_kind(value)}"


def _finite(value: Any) -> bool:
    return isinstance(value, float) and math.isfinite(value)


def _kind(value: Any) -> str:
    names = {dict: "object", list: "list", str: "text", float: "number", bool: "true or false"}
    return names.get(type(value), "null")
