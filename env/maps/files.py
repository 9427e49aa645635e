"""Read maps from files."""

from __future__ import annotations

from pathlib import Path

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.maps.doorways import open_doorways
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.image import check_file, read_plain
from indoor_explorers.env.maps.reduction import Source, cropped, reduced
from indoor_explorers.env.maps.ros import read_ros

ROS_SUFFIXES = (".yaml", ".yml")
IMAGE_SUFFIXES = (".png", ".pgm", ".pnm", ".bmp")


def read_map(path: str | Path, resolution: float | None = None) -> Floorplan:
    """Read a map file as a floor plan with cells of ``resolution`` metres; None keeps the file's.

    A ``.yaml`` is a ROS map_server map: doorways that it leaves unknown are opened, and the unknown around
    the building is cut away. A picture is a plain map, bright is free; one pixel counts as one metre and
    nothing is cut away. In both, only the largest connected free part stays free; see
    :func:`~indoor_explorers.env.maps.reduction.reduced`.

    Raises :class:`InputError` with one line for whatever is wrong with the file or the resolution.
    """
    path = Path(path)
    check_file(path)
    suffix = path.suffix.lower()
    if suffix in ROS_SUFFIXES:
        cells, metres = read_ros(path)
        source = Source(name=path.stem, where=str(path), cells=open_doorways(cells, metres), resolution=metres)
        return cropped(reduced(source, resolution))
    if suffix in IMAGE_SUFFIXES:
        return reduced(Source(name=path.stem, where=str(path), cells=read_plain(path), resolution=1.0), resolution)
    raise InputError(
        f"{path}: expected a map ending in {', '.join(ROS_SUFFIXES + IMAGE_SUFFIXES)}, got {suffix or 'no ending'!r}; "
        "convert it to one of these"
    )
