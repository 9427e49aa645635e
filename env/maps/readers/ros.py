"""Occupancy maps as ROS map_server saves them: a YAML file that names a picture and says how to read it.

Format: http://wiki.ros.org/map_server#YAML_format.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import expanded
from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.readers.image import read_picture
from indoor_explorers.env.maps.readers.opening import Fits, check_file, read_yaml

#: The most bytes a YAML file may have; real ones have about 200.
MAX_BYTES = 65_536
#: The deepest nesting a YAML file may have; real ones have two levels.
MAX_DEPTH = 8
#: Nav2's map saver writes this ``free_thresh`` beside the shade 205 for unknown cells, an occupancy of 0.1961, so that
#: they would be read as free (https://github.com/SteveMacenski/slam_toolbox/issues/587).
NAV2_FREE_THRESH = 0.25
#: What ROS 1's map saver writes, which keeps that shade unknown.
FREE_THRESH = 0.196

_SWITCH = {"0": False, "false": False, "no": False, "off": False, "1": True, "true": True, "yes": True, "on": True}
_NEEDED = {
    "image": "the picture's path, relative to this file",
    "resolution": "metres a pixel, such as 0.05",
    "negate": "0, or 1 when black is free",
    "occupied_thresh": "a share such as 0.65",
    "free_thresh": "a share such as 0.196",
}


@dataclass(frozen=True, kw_only=True)
class RosMap:
    """Hold the facts of a map_server YAML file."""

    image: Path
    """The picture."""
    resolution: float
    """Metres a pixel."""
    negate: bool = False
    """True when white is occupied and black is free."""
    occupied_thresh: float = 0.65
    """A pixel is occupied above this occupancy (0 to 1)."""
    free_thresh: float = FREE_THRESH
    """A pixel is free below this occupancy (0 to 1)."""
    yaw: float = 0.0
    """Rotation of the picture in the world, radians; a note reports it, and it is otherwise ignored."""
    scale: bool = False
    """True in map_server's mode ``scale``, where transparent pixels are unknown."""


def read_ros(path: Path, fits: Fits | None = None) -> tuple[Belief, float]:
    """Read a map_server map; return its (H, W) uint8 cells (0 unknown, 1 free, 2 occupied) and metres a pixel.

    The thresholds act as in map_server's mode ``trinary``, but what Nav2 saved as unknown is unknown; in mode ``scale``
    transparent pixels are unknown. Mode ``raw`` is refused, since its values are not occupancies. The origin, with its
    yaw, is checked and ignored. ``fits`` checks the picture's size before it is decoded.
    """
    facts = parse_ros(path)
    try:
        check_file(facts.image)
    except InputError as error:
        raise InputError(f"{path}: image: {error}") from error
    picture = read_picture(facts.image, fits, facts.resolution)
    cells = trinary(picture.channels, facts)
    if facts.scale and picture.opaque is not None:
        cells[~picture.opaque] = UNKNOWN
    return cells, facts.resolution


def trinary(channels: NDArray[np.uint8], facts: RosMap) -> Belief:
    """Classify (H, W, C) colour channels exactly as map_server does; return (H, W) uint8 cells.

    With x the mean of the channels, the occupancy is ``p = (255 - x) / 255``, or ``x / 255`` when negated.
    Occupied means p > occupied_thresh, free p < free_thresh, both strictly; all else is unknown.
    """
    count = channels.shape[2]
    shade = np.arange(255 * count + 1) / count
    p = (shade if facts.negate else 255.0 - shade) / 255.0
    values = np.where(p > facts.occupied_thresh, OCCUPIED, np.where(p < facts.free_thresh, FREE, UNKNOWN))
    return np.asarray(values.astype(np.uint8)[channels.sum(axis=2, dtype=np.uint16)])


def parse_ros(path: Path) -> RosMap:
    """Read and check a map_server YAML file; of a repeated key the last one counts, unknown keys are ignored.

    A file as Nav2's map saver writes it has a ``free_thresh`` of :data:`FREE_THRESH` instead of its own, see
    :data:`NAV2_FREE_THRESH`.

    Raises :class:`InputError` with one line that says what is wrong with it.
    """
    data = read_yaml(path, MAX_BYTES, MAX_DEPTH, "resolution: 0.05", "a map_server file")
    for key, meaning in _NEEDED.items():
        if key not in data:
            got = ", ".join(str(name)[:40] for name in list(data)[:12])
            raise InputError(f"{path}: expected the key {key!r} ({meaning}), got only {got}; add it")
    facts = RosMap(
        yaw=_yaw(path, data.get("origin")),
        image=path.parent / expanded(_text(path, data, "image")),
        resolution=_number(path, data, "resolution", 1e-6, 1e6),
        negate=_choice(path, data, "negate", _SWITCH),
        occupied_thresh=_number(path, data, "occupied_thresh", 0.0, 1.0),
        free_thresh=_free_thresh(path, data),
        scale=_choice(path, {"mode": "trinary"} | dict(data), "mode", {"trinary": False, "scale": True}),
    )
    if facts.free_thresh >= facts.occupied_thresh:
        raise InputError(
            f"{path}: expected free_thresh below occupied_thresh, "
            f"got {facts.free_thresh:g} and {facts.occupied_thresh:g}; are they swapped?"
        )
    return facts


def _free_thresh(path: Path, data: Mapping[str, Any]) -> float:
    value = _number(path, data, "free_thresh", 0.0, 1.0)
    by_nav2 = value == NAV2_FREE_THRESH and data.get("mode") == "trinary"
    return FREE_THRESH if by_nav2 and not _choice(path, data, "negate", _SWITCH) else value


def _text(path: Path, data: Mapping[str, Any], key: str) -> str:
    value = data[key]
    if isinstance(value, str) and value:
        return value
    raise InputError(f"{path}: {key}: expected {_NEEDED.get(key, 'text')}, got {_shown(value)}; correct it")


def _number(path: Path, data: Mapping[str, Any], key: str, low: float, high: float) -> float:
    try:
        value = float(data[key])
    except (TypeError, ValueError):
        value = math.nan
    if low <= value <= high:
        return value
    raise InputError(
        f"{path}: {key}: expected a number from {low:g} to {high:g} ({_NEEDED[key]}), "
        f"got {_shown(data[key])}; correct it"
    )


def _choice(path: Path, data: Mapping[str, Any], key: str, choices: Mapping[str, bool]) -> bool:
    value = data[key]
    if isinstance(value, str) and value.lower() in choices:
        return choices[value.lower()]
    raise InputError(f"{path}: {key}: expected one of {', '.join(choices)}, got {_shown(value)}; correct it")


def _yaw(path: Path, origin: object) -> float:
    if origin is None:
        return 0.0
    try:
        if isinstance(origin, list) and len(origin) == 3 and all(math.isfinite(float(part)) for part in origin):
            return float(origin[2])
    except (TypeError, ValueError):
        pass
    raise InputError(f"{path}: origin: expected three numbers [x, y, yaw], got {_shown(origin)}; correct it")


def _shown(value: object) -> str:
    if isinstance(value, str):
        return repr(value[:60])
    return "a list" if isinstance(value, list) else "a mapping"
