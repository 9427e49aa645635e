"""Buildings of several storeys that the traffic editor of Open-RMF saves, ``NAME.building.yaml``.

Format: https://osrf.github.io/ros2multirobotbook/traffic-editor.html. Read are each level's vertices, walls, doors,
floors, holes, measurements, fiducials and elevation, and the lifts, but not the furniture (``models``), whose shapes
are in other files. As in the editor, metres a pixel are the mean of a level's measurements, and fiducials of one name
lie above each other.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.maps.readers.opening import read_yaml

#: The ending of such files; other ``.yaml`` files are ROS maps.
ENDING = ".building.yaml"
#: The most bytes a file may have, and the deepest nesting; real ones have up to 280,000 and eight levels.
MAX_BYTES, MAX_DEPTH = 5_000_000, 16
#: Metres from the middle of a lift's door to the cabin and to the floor.
LIFT_DOOR = 0.5
#: Metres from a floor to the next where neither settings nor elevations say.
STOREY = 3.0
_EXPECTED = {
    "elevation": "metres",
    "vertices": "lists [x, y, ...] of numbers",
    "fiducials": "lists [x, y, name]",
    "measurements": "lists [vertex, vertex, {distance: [3, metres]}] of two places",
    "walls": "lists [vertex, vertex, ...] of numbers of vertices",
    "doors": "lists [vertex, vertex, ...] of numbers of vertices",
    "floors": "mappings with vertices: [vertex, vertex, vertex, ...]",
    "holes": "mappings with vertices: [vertex, vertex, vertex, ...]",
    "lifts": "x, y, yaw, width, depth, doors with x, y, width and motion_axis_orientation, and names of levels",
}

Points = NDArray[np.complex128]
"""Places x + iy in metres, x to the right and y downwards."""


class BuildingSettings(BaseModel):
    """How buildings of several storeys are read; other maps do without."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)

    storey: str | None = None
    """Name of the storey to explore alone, as a map of one level; None: all of them, with the slabs between."""
    storey_height: float = Field(STOREY, ge=0.0, le=1000.0)
    """Metres from a floor to the next; 0: those between the file's elevations."""
    door_height: float = Field(2.1, gt=0.0, le=1000.0)
    """Metres from the floor to the lintel of a door; above it, the wall is closed."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Storey:
    """A level of a building, in metres."""

    name: str
    elevation: float
    walls: Points
    """(n, 2) ends."""
    doors: Points
    """(m, 2) ends."""
    floors: list[Points]
    """Outlines of the floors."""
    holes: list[Points]
    """Outlines of the holes in the floors."""
    shafts: list[Points]
    """(4,) corners of the cabins of lifts that stop here or pass."""
    gates: list[Points]
    """(4,) corners of the ways through the doors of those lifts."""


def parse_rmf(path: Path) -> list[Storey]:
    """Return the storeys of a file that have walls and floors, the lowest first.

    Raises :class:`InputError` with one line that says what is wrong with the file.
    """
    data = read_yaml(path, MAX_BYTES, MAX_DEPTH, "levels: ...", "a building of Open-RMF")
    levels = data.get("levels")
    if not isinstance(levels, dict) or not all(isinstance(level, dict) for level in levels.values()):
        raise InputError(f"{path}: levels: expected a mapping of levels by name, got {levels!r:.40}; is it a building?")
    system = data.get("coordinate_system", "reference_image")
    if system not in ("reference_image", "cartesian_meters"):
        raise InputError(f"{path}: coordinate_system: expected reference_image or cartesian_meters, got {system!r:.40}")
    built = {name: level for name, level in levels.items() if level.get("walls") and level.get("floors")}
    if not built:
        raise InputError(f"{path}: levels: expected one with walls and floors, got {', '.join(levels)[:60] or 'none'}")
    home = str(data.get("reference_level_name", ""))
    home = home if home in built else next(iter(built))
    places = _placed(path, built, home, metric=system == "cartesian_meters")
    with _expecting(path, "", "elevation"):
        heights = {name: float(level.get("elevation", 0.0)) for name, level in built.items()}
    lifts = list(_lifts(path, data.get("lifts") or {}, places, heights))
    found = [_storey(path, name, built[name], places[name], heights[name], lifts) for name in built]
    return sorted(found, key=lambda storey: storey.elevation)


def chosen(path: Path, storeys: list[Storey], name: str) -> Storey:
    """Return the storey of a name."""
    if found := [storey for storey in storeys if storey.name == name]:
        return found[0]
    raise InputError(f"{path}: no storey {name!r} with walls and floors{did_you_mean(name, [s.name for s in storeys])}")


@contextmanager
def _expecting(path: Path, level: str, part: str) -> Iterator[None]:
    """Turn whatever fails while a part of a level is read into :class:`InputError`."""
    try:
        yield
    except InputError:
        raise
    except (ArithmeticError, AttributeError, KeyError, LookupError, TypeError, ValueError) as error:
        got = " ".join(str(error).split())[:80]
        where = f"levels: {level}: {part}" if level else part
        raise InputError(f"{path}: {where}: expected {_EXPECTED[part]}, got others ({got}); correct it") from error


def _points(rows: Any) -> Points:
    """Return the places of lists [x, y, ...] of text."""
    found = np.array([complex(float(row[0]), float(row[1])) for row in rows or ()], np.complex128)
    if not np.isfinite(found).all() or (np.abs(found) > 1e7).any():
        raise ValueError("a number that is not finite, or above 1e7")
    return found


class _Place:
    """How the drawing of a level lies in the building: turned and scaled by ``turn``, then moved by ``shift``."""

    def __init__(self, points: Points, turn: complex, shift: complex = 0.0, mirrored: bool = False) -> None:
        self.turn, self.shift, self.mirrored = turn, shift, mirrored
        self.points = self.of(points)

    def of(self, points: Points) -> Points:
        """Return places of the drawing in metres."""
        return (points.conj() if self.mirrored else points) * self.turn + self.shift


def _placed(path: Path, levels: Mapping[str, Any], home: str, *, metric: bool) -> dict[str, _Place]:
    """Return the place of each level, from its fiducials that the reference level has too, else its measurements."""
    found: dict[str, _Place] = {}
    marks: dict[str, dict[str, complex]] = {}
    for name in (home, *(name for name in levels if name != home)):
        level = levels[name]
        with _expecting(path, name, "vertices"):
            points = _points(level["vertices"])
        with _expecting(path, name, "fiducials"):
            rows = level.get("fiducials") or ()
            marks[name] = dict(zip([str(row[2]) for row in rows], _points(rows), strict=True))
        if metric:
            found[name] = _Place(points, 1.0, mirrored=True)
            continue
        common = [mark for mark in marks[home] if mark in marks[name]] if name != home else []
        here, there = (np.array([marks[of][mark] for mark in common]) for of in (name, home))
        if len(common) > 1 and np.ptp(here.real) + np.ptp(here.imag) > 0:
            middle, target = here.mean(), found[home].of(there)
            turn = np.vdot(here - middle, target - target.mean()) / np.vdot(here - middle, here - middle)
            found[name] = _Place(points, complex(turn), complex(target.mean() - turn * middle))
        else:
            found[name] = _Place(points, _scale(path, name, level, points))
    return found


def _scale(path: Path, name: str, level: Mapping[str, Any], points: Points) -> float:
    """Return metres a pixel."""
    with _expecting(path, name, "measurements"):
        rows = level.get("measurements") or ()
        ends = points[[[int(row[0]), int(row[1])] for row in rows]] if rows else np.zeros((0, 2))
        scales = [
            float(row[2]["distance"][1]) / float(abs(first - last))
            for row, (first, last) in zip(rows, ends, strict=True)
        ]
        if not scales or not 1e-6 <= np.mean(scales) <= 1e3:
            raise ValueError(f"{len(scales)} measurements")
        return float(np.mean(scales))


def _storey(
    path: Path, name: str, level: Mapping[str, Any], place: _Place, elevation: float, lifts: list[_Lift]
) -> Storey:
    segments, outlines = {}, {}
    for part in ("walls", "doors"):
        with _expecting(path, name, part):
            ends = [[int(row[0]), int(row[1])] for row in level.get(part) or ()]
            segments[part] = place.points[np.reshape(np.array(ends, np.int64), (-1, 2))]
    for part in ("floors", "holes"):
        with _expecting(path, name, part):
            outlines[part] = [place.points[[int(each) for each in row["vertices"]]] for row in level.get(part) or ()]
    here = [lift for lift in lifts if lift.lowest <= elevation <= lift.highest]
    return Storey(
        name=name,
        elevation=elevation,
        walls=segments["walls"],
        doors=segments["doors"],
        floors=[outline for outline in outlines["floors"] if len(outline) > 2],
        holes=[outline for outline in outlines["holes"] if len(outline) > 2],
        shafts=[lift.cabin for lift in here],
        gates=[gate for lift in here for gate in lift.gates.get(name, ())],
    )


@dataclass(frozen=True, eq=False)
class _Lift:
    cabin: Points
    lowest: float
    highest: float
    gates: dict[str, list[Points]]


def _lifts(path: Path, lifts: Any, places: Mapping[str, _Place], heights: Mapping[str, float]) -> Iterator[_Lift]:
    """Yield the lifts of a building; those of levels without walls and floors are left out."""
    with _expecting(path, "", "lifts"):
        for lift in lifts.values():
            ends = [heights.get(lift[end]) for end in ("lowest_floor", "highest_floor")]
            place = places.get(lift["reference_floor_name"])
            if place is None or ends[0] is None or ends[1] is None:
                continue
            middle = place.of(_points([(lift["x"], lift["y"])]))[0]
            cabin = _rectangle(0j, 1 + 0j, float(lift["width"]), float(lift["depth"]))
            turn = np.exp(1j * float(lift["yaw"]))
            gates = {}
            for name, door in lift["doors"].items():
                along = np.exp(1j * float(door.get("motion_axis_orientation", 0.0)))
                gates[name] = _rectangle(
                    _points([(door["x"], door["y"])])[0], along, float(door["width"]), 2 * LIFT_DOOR
                )
            stops = {level: [gates[name] for name in doors] for level, doors in lift["level_doors"].items()}
            yield _Lift(  # y is upwards in a lift, and downwards in a building
                middle + (cabin * turn).conj(),
                min(ends[0], ends[1]),
                max(ends[0], ends[1]),
                {level: [middle + (gate * turn).conj() for gate in found] for level, found in stops.items()},
            )


def _rectangle(middle: complex, along: complex, width: float, depth: float) -> Points:
    """Return the (4,) corners of a rectangle of a ``width`` along a direction."""
    corners = np.array([-1 - 1j, 1 - 1j, 1 + 1j, -1 + 1j])
    return middle + along * (corners.real * width + 1j * corners.imag * depth) / 2
