"""Read maps from files, and write them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import expanded
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.readers.building import read_building
from indoor_explorers.env.maps.readers.houseexpo import RESOLUTION, read_houseexpo
from indoor_explorers.env.maps.readers.image import read_plain
from indoor_explorers.env.maps.readers.movingai import read_movingai
from indoor_explorers.env.maps.readers.npy import inverted_notes, read_npy
from indoor_explorers.env.maps.readers.octomap import read_octomap, write_octomap
from indoor_explorers.env.maps.readers.opening import Fits, check_file, read_json
from indoor_explorers.env.maps.readers.rmf import ENDING as BUILDING
from indoor_explorers.env.maps.readers.rmf import BuildingSettings
from indoor_explorers.env.maps.readers.ros import parse_ros, read_ros
from indoor_explorers.env.maps.readers.sheet import PIXEL
from indoor_explorers.env.maps.readers.storeys import RESOLUTION as STOREYS_RESOLUTION
from indoor_explorers.env.maps.readers.storeys import draw_storey, stack_storeys
from indoor_explorers.env.maps.readers.surfaces import read_surfaces
from indoor_explorers.env.maps.readers.vectormap import read_vectormap
from indoor_explorers.env.maps.reduction import (
    Source,
    check_resolution,
    checked_factor,
    cropped,
    open_doorways,
    reduced,
)
from indoor_explorers.env.search.connected_parts import largest_part


def read_map(path: str | Path, resolution: float | None = None, building: BuildingSettings | None = None) -> Floorplan:
    """Read a map file as a floor plan with cells of ``resolution`` metres; None keeps the file's.

    The file's ending decides its kind, and ``building`` how those of several storeys are read. Only the largest
    connected free part of a map stays free, see :func:`~indoor_explorers.env.maps.reduction.reduced`.

    - ``.yaml``, ``.yml``: a ROS map_server map; doorways that it leaves unknown are opened, and the unknown around
      the building is cut away. A yaw of its origin is ignored; what Nav2 saved as unknown is unknown.
    - ``.png``, ``.pgm``, ``.pnm``, ``.bmp``: a plain picture; bright is free, transparent is white, and a coloured
      spot marks the start.
    - ``.map``: a grid of the MovingAI benchmarks.
    - ``.npy``: a NumPy array of occupancies; with three axes, the levels of a volume, lowest first.
    - ``.json``, an object: a HouseExpo outline, cut to the house; cells of 0.1 m where none are asked for.
    - ``.json``, a list: the wall segments of an AMRL vector map, drawn in pixels of 0.1 m and cut like a ROS map.
    - ``.xml``: the rooms and portals of a building, drawn, opened and cut in the same way.
    - ``.building.yaml``: the storeys of a building of Open-RMF, with cells of 0.5 m, or one of them, drawn, opened and
      cut in the same way.
    - ``.bt``: an octree of OctoMap; unknown is solid.
    - ``.stl``, ``.ply``, ``.obj``, ``.pcd``: a mesh or a cloud of points in metres, with cells of 0.25 m.

    A pixel of a plain picture, a character of a grid and an element of an array count as one metre, and nothing is cut
    away.

    Raises :class:`InputError` with one line that describes the fault of the file or the resolution.
    """
    path = expanded(path)
    check_file(path)
    suffix = BUILDING if path.name.lower().endswith(BUILDING) else path.suffix.lower()
    if suffix not in READERS:
        raise InputError(
            f"{path}: expected a map ending in {', '.join(READERS)}, got {suffix or 'no ending'!r}; "
            "convert it to one of these"
        )
    if resolution is not None:
        check_resolution(str(path), resolution)
    if suffix == BUILDING:
        return _read_storeys(path, resolution, building or BuildingSettings())
    return READERS[suffix](path, resolution)


def write_map(floorplan: Floorplan, path: Path, kind: str) -> None:
    """Write the cells of a floor plan as :func:`read_map` reads them, without its start, to a file of a ``kind``.

    A ``.png`` holds a map of one level, an array ``.npy`` the obstacles of any, and an OctoMap ``.bt`` any with its
    scale, one metre a cell where it has none.

    Raises:
        InputError: the kind is none of these, or cannot hold several levels.

    """
    cells = floorplan.levels.volume(floorplan.truth)
    if kind == ".bt":
        write_octomap(cells, floorplan.resolution or 1.0, path)
    elif kind == ".npy":
        with path.open("wb") as file:
            np.save(file, (cells if len(cells) > 1 else cells[0]) != FREE)
    elif kind == ".png" and len(cells) == 1:
        write_picture(floorplan, path)
    else:
        which = f" that holds {len(cells)} levels: .npy or .bt" if len(cells) > 1 else ": .png, .npy or .bt"
        raise InputError(f"expected a kind of map file{which}, got {kind or 'no ending'!r}")


def write_picture(floorplan: Floorplan, path: Path) -> None:
    """Write the cells of a floor plan as a PNG picture that :func:`read_map` reads, without its start."""
    grey = np.where(floorplan.truth == FREE, 255, 0).astype(np.uint8)
    Image.fromarray(grey).save(path, format="PNG", optimize=True)


def _fits(path: Path, resolution: float | None) -> Fits:
    """Return the check that a map of these pixels can have cells of ``resolution`` metres."""
    return lambda shape, metres: checked_factor(str(path), shape, metres, resolution)


def _read_ros(path: Path, resolution: float | None) -> Floorplan:
    plan = _indoors(path, *read_ros(path, _fits(path, resolution)), resolution)
    yaw = parse_ros(path).yaw
    turned = f"{path.name}: the map is flown as its picture lies: the yaw of its origin, {yaw:g} rad, is ignored"
    return replace(plan, notes=(turned,)) if yaw else plan


def _read_xml(path: Path, resolution: float | None) -> Floorplan:
    return _indoors(path, *read_building(path, _fits(path, resolution)), resolution)


def _read_json(path: Path, resolution: float | None) -> Floorplan:
    data = read_json(path)
    if isinstance(data, list):
        return _indoors(path, *read_vectormap(path, data, _fits(path, resolution)), resolution)
    asked = RESOLUTION if resolution is None else resolution
    cells, metres = read_houseexpo(path, data, asked)
    return cropped(reduced(Source(name=path.stem, where=str(path), cells=cells, resolution=metres), asked))


def _indoors(path: Path, cells: Belief, metres: float, resolution: float | None) -> Floorplan:
    """Return the floor plan of cells that are unknown around the building, and perhaps in its doorways."""
    source = Source(name=_stem(path), where=str(path), cells=open_doorways(cells, metres), resolution=metres)
    return cropped(reduced(source, resolution))


def _read_plain(path: Path, resolution: float | None) -> Floorplan:
    cells, start = read_plain(path, _fits(path, resolution))
    return reduced(Source(name=path.stem, where=str(path), cells=cells, resolution=1.0, start=start), resolution)


def _read_movingai(path: Path, resolution: float | None) -> Floorplan:
    return reduced(Source(name=path.stem, where=str(path), cells=read_movingai(path), resolution=1.0), resolution)


def _read_npy(path: Path, resolution: float | None) -> Floorplan:
    cells = read_npy(path, _fits(path, resolution))
    if cells.ndim > 2:
        return _volume(path, cells, resolution)
    plan = reduced(Source(name=path.stem, where=str(path), cells=cells, resolution=1.0), resolution)
    return replace(plan, notes=inverted_notes(path, cells))


def _volume(path: Path, cells: Belief, resolution: float | None) -> Floorplan:
    if resolution not in (None, 1.0):
        raise InputError(
            f"{path}: expected no --resolution for an array of several levels, got {resolution:g}; omit it"
        )
    return replace(_stacked(path, cells, 1.0), notes=inverted_notes(path, cells))


def _read_octomap(path: Path, resolution: float | None) -> Floorplan:
    return _stacked(path, *read_octomap(path, resolution))


def _read_surfaces(path: Path, resolution: float | None) -> Floorplan:
    return _stacked(path, *read_surfaces(path, resolution), around=(1, 1, 1))


def _read_storeys(path: Path, resolution: float | None, settings: BuildingSettings) -> Floorplan:
    if settings.storey is None:
        return _stacked(path, *stack_storeys(path, settings, resolution), around=(0, 1, 1))
    asked = STOREYS_RESOLUTION if resolution is None else resolution
    plan = _indoors(path, draw_storey(path, settings, asked), PIXEL, asked)
    return replace(plan, name=f"{plan.name}-{settings.storey}")


def _stacked(path: Path, cells: Belief, metres: float, around: tuple[int, int, int] | None = None) -> Floorplan:
    """Return the map of (L, H, W) cells of so many ``metres``, of which only the largest connected part stays free.

    It is cut to its free cells and so many solid levels, rows and columns ``around`` them; None: left as it is.
    """
    free = cells == FREE
    kept = largest_part(free)
    if not kept.any():
        raise InputError(f"{path}: expected some free cells, got none; is it a map, is --resolution fine enough?")
    share = float(kept.sum() / free.sum())
    if around is not None:
        places = np.argwhere(kept)
        low, high = places.min(axis=0), places.max(axis=0) + 1
        inner = kept[tuple(slice(first, last) for first, last in zip(low, high, strict=True))]
        kept = np.pad(inner, [(solid, solid) for solid in around])
    return replace(Floorplan.from_free(kept, _stem(path), metres, kept=share), connected=share)


def _stem(path: Path) -> str:
    """Return the name of a file without its ending."""
    return path.name[: -len(BUILDING)] if path.name.lower().endswith(BUILDING) else path.stem


#: How a file is read, by its ending.
READERS: dict[str, Callable[[Path, float | None], Floorplan]] = {
    **dict.fromkeys((".yaml", ".yml"), _read_ros),
    **dict.fromkeys((".png", ".pgm", ".pnm", ".bmp"), _read_plain),
    ".map": _read_movingai,
    ".npy": _read_npy,
    ".json": _read_json,
    ".xml": _read_xml,
    BUILDING: lambda path, resolution: _read_storeys(path, resolution, BuildingSettings()),
    ".bt": _read_octomap,
    **dict.fromkeys((".stl", ".ply", ".obj", ".pcd"), _read_surfaces),
}
