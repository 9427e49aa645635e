"""Floors of buildings as rooms and portals in XML: the schools and offices of Luperto and Amigoni.

Format: https://github.com/goldleaf3i/generativeCMLgraphs. Files may come from anywhere: size and depth are
limited, and document types, which declare entities, are refused. Read are the scale, the corners of each space's
``bounding_polygon``, x to the right and y downwards, and its line segments of the class PORTAL.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.readers.opening import Fits, one_line, read_bytes
from indoor_explorers.env.maps.readers.sheet import PIXEL, Sheet, within

#: The most bytes a file may have; real ones have up to half a million.
MAX_BYTES = 2_000_000
#: The deepest nesting of elements; real files have eight levels.
MAX_DEPTH = 32
#: Metres around the rooms.
MARGIN = 1.0
#: Doors are opened this wide, in metres, around the middle of a portal.
DOOR = 0.9
#: The most spaces, and the most corners of all of them; real floors have up to 119 and 1,054.
MAX_SPACES, MAX_CORNERS = 1_000, 5_000
#: Units of the scale's real distance in a metre.
UNITS = {"mm": 1000.0, "cm": 100.0, "m": 1.0}


@dataclass(frozen=True, eq=False, kw_only=True)
class Building:
    """The rooms and doors of a floor, in metres."""

    outlines: list[NDArray[np.float64]]
    """(n, 2) corners (x, y) of each room, at least three."""
    portals: NDArray[np.float64]
    """(m, 2) middles of the doors."""


def read_building(path: Path, fits: Fits | None = None) -> tuple[Belief, float]:
    """Draw a building's ``.xml`` file; return (H, W) uint8 cells and metres a pixel.

    The outlines of the rooms are occupied (2) but for the doors, their insides and one pixel around them are free (1),
    and all else is unknown (0). ``fits`` checks the size before anything is drawn.

    Raises :class:`InputError` with one line that says what is wrong with the file.
    """
    building = parse_building(path)
    sheet = Sheet.around(path, np.concatenate(building.outlines), MARGIN, fits)
    cells = np.where(within(sheet.areas(building.outlines), 1), np.uint8(FREE), np.uint8(UNKNOWN))
    walls = sheet.lines(np.append(outline, outline[:1], axis=0) for outline in building.outlines)
    cells[walls] = OCCUPIED
    cells[walls & sheet.discs(building.portals, DOOR)] = FREE
    return cells, PIXEL


def parse_building(path: Path) -> Building:
    """Read and check a building's XML file; spaces without corners are left out."""
    root = read_xml(path, "building")
    if len(floors := root.findall("floor")) > 1:
        raise InputError(f"{path}: expected one floor, got {len(floors)}; save each in a file of its own")
    spaces = root.findall("floor/spaces/space")
    count = len(root.findall("floor/spaces/space/bounding_polygon/point"))
    if not (1 <= len(spaces) <= MAX_SPACES and 1 <= count <= MAX_CORNERS):
        raise InputError(
            f"{path}: expected 1 to {MAX_SPACES:,} spaces with 1 to {MAX_CORNERS:,} corners in their bounding_polygon, "
            f"got {len(spaces):,} with {count:,}; is it a floor of rooms?"
        )
    scale = _scale(path, root)
    outlines = [_points(path, space, "bounding_polygon") * scale for space in spaces]
    if wrong := [len(outline) for outline in outlines if 0 < len(outline) < 3]:
        raise InputError(f"{path}: bounding_polygon: expected at least 3 points, got {wrong[0]}; correct it")
    segments = (segment for space in spaces for segment in space.findall("space_representation/linesegment"))
    doors = [_points(path, segment) * scale for segment in segments if segment.findtext("class") == "PORTAL"]
    middles = [door.mean(axis=0) for door in doors if len(door)]
    return Building(outlines=[outline for outline in outlines if len(outline)], portals=np.reshape(middles, (-1, 2)))


class _Builder(ElementTree.TreeBuilder):
    """Build the tree of a document that has no document type and is not nested deeply."""

    depth = 0

    def doctype(self, name: str, public: str | None, system: str | None) -> None:
        raise ValueError("a DOCTYPE, which may declare entities")

    def start(self, tag: str, attrs: dict[str, str]) -> ElementTree.Element:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise ValueError(f"elements nested deeper than {MAX_DEPTH} levels")
        return super().start(tag, attrs)

    def end(self, tag: str) -> ElementTree.Element:
        self.depth -= 1
        return super().end(tag)


def read_xml(path: Path, root: str) -> ElementTree.Element:
    """Return the root element of an XML file, which must have the tag ``root``.

    Raises :class:`InputError` for a file that is no XML, too large, too deep, or has a document type.
    """
    text = read_bytes(path, MAX_BYTES, "an XML map")
    parser = ElementTree.XMLParser(target=_Builder())
    try:
        parser.feed(text)
        element = parser.close()
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise InputError(f"{path}: expected plain XML, got {one_line(error)}; correct it") from error
    if element.tag != root:
        raise InputError(f"{path}: expected the element <{root}>, got <{element.tag[:40]}>; is it a floor of rooms?")
    return element


def _scale(path: Path, root: ElementTree.Element) -> float:
    """Return metres a unit of the drawing."""
    unit = root.findtext("scale/real_distance/um", "nothing")
    if unit not in UNITS:
        raise InputError(
            f"{path}: scale/real_distance/um: expected one of {', '.join(UNITS)}, got {unit[:40]!r}; correct it"
        )
    return _distance(path, root, "real_distance") / UNITS[unit] / _distance(path, root, "represented_distance")


def _distance(path: Path, root: ElementTree.Element, name: str) -> float:
    text = root.findtext(f"scale/{name}/value", "nothing")
    if 1e-3 <= (value := _number(text)) <= 1e6:
        return value
    raise InputError(
        f"{path}: scale/{name}/value: expected a number from 0.001 to 1000000, got {text[:40]!r}; correct it"
    )


def _points(path: Path, element: ElementTree.Element, below: str = ".") -> NDArray[np.float64]:
    """Return the (n, 2) points of an element, x before y."""
    points = [[_number(point.get(axis, "")) for axis in "xy"] for point in element.findall(f"{below}/point")]
    if all(abs(value) <= 1e9 for point in points for value in point):
        return np.reshape(np.array(points, np.float64), (-1, 2))
    raise InputError(f"{path}: point: expected numbers x and y of at most 1000000000, got others; correct it")


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
