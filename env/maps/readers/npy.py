"""Maps saved with ``numpy.save``: masks, occupancy grids and occupancy probabilities.

Format: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.readers.opening import Fits, check_pixels, decoding

#: Occupancies between these are unknown, as map_server's are by default.
FREE_BELOW, OCCUPIED_ABOVE = 0.196, 0.65

#: The most bytes of a header; numpy allocates the promised length before it refuses a longer one.
MAX_HEADER = 10_000

_HEADERS = {(1, 0): (npy.read_array_header_1_0, 2), (2, 0): (npy.read_array_header_2_0, 4)}
"""How to read the header of each version, and the bytes that hold its length."""


def read_npy(path: Path, fits: Fits | None = None) -> Belief:
    """Read a ``.npy`` array as (H, W) or (L, H, W) uint8 cells (0 unknown, 1 free, 2 occupied); L levels, lowest first.

    - bool and unsigned integers: 0 is free, all else occupied;
    - signed integers: 0 is free, -1 unknown, all else occupied; but where the largest value is from 66 to 100, the
      values are occupancies in percent, as in ROS's ``nav_msgs/OccupancyGrid``;
    - floats: occupancies from 0 to 1, or -1 for unknown.

    An occupancy is free below :data:`FREE_BELOW`, occupied above :data:`OCCUPIED_ABOVE` and unknown between.
    ``fits`` checks the size, an element counting as a metre, before the data is read.

    Raises :class:`InputError` with one line that says what is wrong with the file. Nothing is ever unpickled.
    """
    with decoding(path, "a file of numpy.save"), path.open("rb") as file:
        shape, dtype = _parse_header(path, file)
        _check(path, shape, dtype)
        if fits is not None:
            fits((int(np.prod(shape[:-1])), shape[-1]), 1.0)
        file.seek(0)
        array = np.load(file, allow_pickle=False)
    return occupancy(path, array)


def _parse_header(path: Path, file: BinaryIO) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Return shape and type of the array; refuse a file with less data than these need."""
    version = npy.read_magic(file)
    if version not in _HEADERS:
        raise InputError(f"{path}: expected numpy's format 1.0 or 2.0, got {version[0]}.{version[1]}; save it again")
    read, length = _HEADERS[version]
    start = file.tell()
    if (size := int.from_bytes(file.read(length), "little")) > MAX_HEADER:
        raise InputError(f"{path}: expected a header of at most {MAX_HEADER:,} bytes, got {size:,}; save it again")
    file.seek(start)
    shape, _, dtype = read(file)
    promised, held = dtype.itemsize, path.stat().st_size - file.tell()
    for side in shape:
        promised *= side
    if not dtype.hasobject and promised > held:
        text = f"{promised:,} bytes" if promised < 10**15 else "far more"
        raise InputError(f"{path}: expected {text} of data, got {held:,}; the file is truncated")
    return shape, dtype


def _check(path: Path, shape: tuple[int, ...], dtype: np.dtype[Any]) -> None:
    """Raise unless the array is a grid of numbers that is not too large."""
    if dtype.kind not in "biuf":
        raise InputError(f"{path}: expected bools, integers or floats, got {str(dtype)[:40]}; save one of these")
    if len(shape) not in (2, 3) or min(shape) < 1:
        raise InputError(
            f"{path}: expected rows and columns, or levels, rows and columns, got an array of shape {str(shape)[:60]}; "
            "save one map"
        )
    check_pixels(path, (int(np.prod(shape[:-1])), shape[-1]), "cells")


def levels_of(path: Path) -> int:
    """Return how many levels the map of a file has by its header; 1 where there is none that can be read."""
    try:
        with path.open("rb") as file:
            shape, _ = _parse_header(path, file)
    except (OSError, ValueError, EOFError):
        return 1
    return max(1, shape[0]) if len(shape) > 2 else 1


def occupancy(path: Path, values: NDArray[Any]) -> Belief:
    """Classify an (H, W) or (L, H, W) array of numbers as :func:`read_npy` says; ``path`` names it in errors."""
    kind = values.dtype.kind
    if kind in "bu":
        return np.where(values == 0, FREE, OCCUPIED).astype(np.uint8)
    unknown = values == -1
    if kind == "i":
        if (wrong := values < -1).any():
            raise InputError(f"{path}: expected -1 for unknown and no lower value, got {_first(values, wrong)}")
        if not OCCUPIED_ABOVE * 100 < values.max() <= 100:
            return np.where(unknown, UNKNOWN, np.where(values == 0, FREE, OCCUPIED)).astype(np.uint8)
        share = values / 100.0
    else:
        share = values
        if (wrong := ~unknown & ~((values >= 0) & (values <= 1))).any():
            raise InputError(
                f"{path}: expected occupancies from 0 to 1, or -1 for unknown, got {_first(values, wrong)}; replace it"
            )
    known = np.where(share < FREE_BELOW, FREE, np.where(share > OCCUPIED_ABOVE, OCCUPIED, UNKNOWN))
    return np.where(unknown, UNKNOWN, known).astype(np.uint8)


def inverted_notes(path: Path, cells: Belief) -> tuple[str, ...]:
    """Return a warning if a file of bools, read as (H, W) ``cells``, looks like a mask of the free cells."""
    with path.open("rb") as file:
        _, dtype = _parse_header(path, file)
    free, border = cells == FREE, np.ones(cells.shape, np.bool_)
    border[..., 1:-1, 1:-1] = False
    if dtype.kind != "b" or border.all() or not free[border].mean() > max(0.5, free[~border].mean()):
        return ()
    return (f"{path.name}: the border is free and the inside is not: True is a wall; if it was to be free, save ~mask",)


def _first(values: NDArray[Any], wrong: NDArray[np.bool_]) -> str:
    place = np.unravel_index(int(np.argmax(wrong)), wrong.shape)
    level = f"level {place[0]}, " if len(place) > 2 else ""
    return f"{values[place]} in {level}row {place[-2]}, column {place[-1]}"
