"""Wall segments in metres: the vector maps of the AMRL group.

Format: https://github.com/ut-amrl/amrl_maps, ``NAME/NAME.vectormap.json``: a JSON list of segments
``{"p0": {"x": 0.0, "y": 0.0}, "p1": {"x": 4.5, "y": 0.0}}``, x to the right and y upwards.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.readers.opening import Fits, finite, kind, shown
from indoor_explorers.env.maps.readers.sheet import PIXEL, Sheet, within
from indoor_explorers.env.search.connected_parts import connected_parts

#: Metres around the walls.
MARGIN = 2.0
#: Radius in metres of the disc that determines the outside: gaps of a facade up to twice as wide are closed.
FACADE = 0.8
#: The most segments a file may have; the largest real one has 6,444.
MAX_SEGMENTS = 20_000


def read_vectormap(path: Path, data: Any, fits: Fits | None = None) -> tuple[Belief, float]:
    """Draw the segments of a file's JSON ``data``; return (H, W) uint8 cells and metres a pixel.

    Walls are occupied (2), cells beyond the facade unknown (0) and all others free (1). ``fits`` checks the size before
    anything is drawn.

    Raises :class:`InputError` with one line that says what is wrong with the file.
    """
    segments = parse_vectormap(path, data) * (1.0, -1.0)
    sheet = Sheet.around(path, segments.reshape(-1, 2), MARGIN, fits)
    walls = sheet.lines(segments)
    cells = np.full(sheet.shape, FREE, np.uint8)
    cells[outside(walls)] = UNKNOWN
    cells[walls] = OCCUPIED
    if not (cells == FREE).any():
        raise InputError(
            f"{path}: expected walls around some floor, with gaps of at most {2 * FACADE:g} m, got none; "
            "close the facade"
        )
    return cells, PIXEL


def outside(walls: Mask) -> Mask:
    """Mark the (H, W) pixels that a disc of radius :data:`FACADE` reaches from the upper left, with adjacent walls."""
    radius = round(FACADE / PIXEL)
    places, _ = connected_parts(~within(walls, radius))
    return within(places == places[0, 0], radius + 1)


def parse_vectormap(path: Path, data: Any) -> NDArray[np.float64]:
    """Return the (n, 2, 2) ends of a vector map's segments in metres, x before y."""
    if not isinstance(data, list) or not 1 <= len(data) <= MAX_SEGMENTS:
        got = f"{len(data)}" if isinstance(data, list) else f"a JSON {kind(data)}"
        raise InputError(f"{path}: expected a list of 1 to {MAX_SEGMENTS:,} wall segments, got {got}; is it a map?")
    return np.array([_ends(path, number, segment) for number, segment in enumerate(data, 1)])


def _ends(path: Path, number: int, segment: Any) -> list[list[float]]:
    ends = [segment.get(name) for name in ("p0", "p1")] if isinstance(segment, dict) else [segment]
    values: list[list[Any]] = [[end.get("x"), end.get("y")] if isinstance(end, dict) else [end] for end in ends]
    if len(values) == 2 and all(len(end) == 2 and finite(end[0]) and finite(end[1]) for end in values):
        return values
    raise InputError(
        f'{path}: expected segments {{"p0": {{"x": 0.0, "y": 0.0}}, "p1": {{"x": 1.0, "y": 0.0}}}} of finite numbers, '
        f"got {', '.join(shown(part) for end in values for part in end)} in number {number}; correct it"
    )
