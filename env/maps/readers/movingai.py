"""Grid maps of the MovingAI benchmarks (Sturtevant 2012, doi 10.1109/TCIAIG.2012.2197681).

Format: https://movingai.com/benchmarks/formats.html. A header of ``type octile``, ``height``, ``width`` and ``map``,
then one line of characters for each row.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.readers.opening import MAX_PIXELS, check_pixels, read_bytes

#: Ground, and swamp, which is no obstacle to a UAV.
PASSABLE = ".GS"
#: Out of bounds, trees, and water, which is passable only from water.
SOLID = "@OTW"
#: The most bytes of a file: one for each cell that a picture may have, and line ends.
MAX_BYTES = 3 * MAX_PIXELS
TYPES = ("octile", "tile")

_HEADER = 1_000
_CELLS = np.full(256, UNKNOWN, np.uint8)
_CELLS[[ord(char) for char in PASSABLE]] = FREE
_CELLS[[ord(char) for char in SOLID]] = OCCUPIED


def read_movingai(path: Path) -> Belief:
    """Read a ``.map`` file as (H, W) uint8 cells: free on :data:`PASSABLE`, occupied on :data:`SOLID` characters.

    Raises :class:`InputError` with one line that says what is wrong with it.
    """
    data = read_bytes(path, MAX_BYTES, "a MovingAI map")
    height, width, body = _parse_header(path, data)
    text = np.frombuffer(data, np.uint8, offset=body)
    if (text == ord("\r")).any():
        text = text[text != ord("\r")]
    if len(text) == height * (width + 1) - 1:  # the last line end is often missing
        text = np.append(text, np.uint8(ord("\n")))
    rows = text[: height * (width + 1)]
    whole = len(rows) == height * (width + 1) and not (text[len(rows) :] != ord("\n")).any()
    grid = rows.reshape(height, width + 1) if whole else rows
    if not whole or (grid[:, :-1] == ord("\n")).any() or (grid[:, -1] != ord("\n")).any():
        raise InputError(f"{path}: {_first_wrong_line(text, height, width)}; correct the header or the map")
    cells = _CELLS[grid[:, :-1]]
    if not cells.all():
        row, col = (int(place) for place in np.argwhere(cells == UNKNOWN)[0])
        raise InputError(
            f"{path}: expected only the characters {PASSABLE} (free) and {SOLID} (solid), "
            f"got {chr(grid[row, col])!r} in row {row + 1}, column {col + 1}; replace it"
        )
    return cells


def _parse_header(path: Path, data: bytes) -> tuple[int, int, int]:
    """Return height, width and where the rows begin."""
    facts: dict[str, str] = {}
    place = 0
    while True:
        end = data.find(b"\n", place, _HEADER)
        if end < 0:
            raise InputError(
                f"{path}: expected the lines 'type octile', 'height H', 'width W' and 'map' first, "
                f"got no line 'map' in the first {_HEADER} bytes; is it a MovingAI map?"
            )
        key, _, value = data[place:end].decode("ascii", errors="replace").strip().partition(" ")
        place = end + 1
        if key == "map":
            break
        facts[key] = value.strip()
    if facts.get("type", "octile") not in TYPES:
        raise InputError(f"{path}: expected type octile, got {facts['type'][:40]!r}; only square grids can be read")
    height, width = (_side(path, facts, name) for name in ("height", "width"))
    check_pixels(path, (height, width), "cells")
    return height, width, place


def _side(path: Path, facts: dict[str, str], name: str) -> int:
    value = facts.get(name)
    if value is None:
        raise InputError(f"{path}: expected a line '{name} N' before the line 'map', got none; add it")
    if not (value.isascii() and value.isdigit() and len(value) <= 9 and int(value) > 0):
        raise InputError(f"{path}: {name}: expected a whole number from 1 to 999999999, got {value[:40]!r}; correct it")
    return int(value)


def _first_wrong_line(text: np.ndarray, height: int, width: int) -> str:
    """Describe the first difference between the rows and the header."""
    if len(text) > height * (width + 1) + 1_000:
        return f"expected {height} rows of {width} characters, got far more"
    ends = np.flatnonzero(np.append(text, np.uint8(ord("\n"))) == ord("\n"))
    lengths = np.diff(ends, prepend=-1) - 1
    wrong = np.flatnonzero(lengths[:height] != width)
    if (len(wrong) and wrong[0] < len(lengths) - 1) or (len(wrong) and lengths[wrong[0]]):
        return f"expected {width} characters in row {wrong[0] + 1}, got {lengths[wrong[0]]}"
    return f"expected {height} rows of {width} characters, got {int((lengths > 0).sum())}"
