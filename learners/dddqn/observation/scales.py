"""Constants of one lidar range and scratch arrays of one map shape for the compiled observation."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.sensing.lidar import LidarModel, Scan, lidar_model, new_scan

#: The lidar range, in cells, that distances and areas are measured in: the thesis's.
REFERENCE_RANGE = 3.0
#: Discounts a step, at the reference range, of the gain ahead.
DISCOUNTS = (0.7, 0.85, 0.95)


class Sensor(NamedTuple):
    """What the observation needs to know about a lidar range; lengths are scaled by ``range / 3``."""

    lidar: LidarModel
    """The lidar."""
    reach: int
    """Cells: the largest row or column offset in range."""
    disc: float
    """Cells in range, the own left out: the most that one scan can reveal."""
    scale: int
    """Cells: side of one pixel of the fine map, odd; also the spacing of the places whose gain is computed."""
    rate: float
    """Reference steps a step: 3 / range."""
    decay: NDArray[np.float64]
    """(3,) discounts of the gain ahead for one step."""


class Scratch(NamedTuple):
    """Arrays that one observation works in, for maps of one shape."""

    steps: NDArray[np.int32]
    """(H, W) distances."""
    first: NDArray[np.uint8]
    """(H, W) the moves, one bit each, that begin a shortest path to a cell."""
    ahead: NDArray[np.float64]
    """(4, 5) what lies behind each move."""
    power: NDArray[np.float64]
    """(3,) discounts of a distance."""
    queue: NDArray[np.int32]
    """(H*W,) flood queue."""
    boxes: NDArray[np.int64]
    """(B, 4) boxes of newly known cells."""
    unknown: NDArray[np.int64]
    """(H + 1, W + 1) summed-area table of unknown cells."""
    free: NDArray[np.int64]
    """(H + 1, W + 1) summed-area table of known free cells."""
    layer: NDArray[np.uint8]
    """(H, W) one layer of the fine map, cell by cell."""
    patch: NDArray[np.uint8]
    """(49,) cells around one."""
    blocked: NDArray[np.uint8]
    """(4,) moves that are blocked."""
    scan: Scan
    """Working arrays of scans."""


@lru_cache(maxsize=32)
def sensor(lidar_range: float) -> Sensor:
    """Return the constants of a lidar range in cells."""
    lidar = lidar_model(lidar_range)
    rate = REFERENCE_RANGE / lidar_range
    return Sensor(
        lidar=lidar,
        reach=int(np.floor(lidar_range + 1e-9)),
        disc=float(lidar.disc),
        scale=2 * int(lidar_range / (2 * REFERENCE_RANGE)) + 1,
        rate=rate,
        decay=np.array(DISCOUNTS) ** rate,
    )


def scratch(shape: tuple[int, int], sensor: Sensor) -> Scratch:
    """Allocate the arrays for a sensor on maps of a (H, W) shape."""
    height, width = shape
    return Scratch(
        steps=np.empty(shape, np.int32),
        first=np.zeros(shape, np.uint8),
        ahead=np.zeros((4, 5)),
        power=np.ones(3),
        queue=np.empty(height * width, np.int32),
        boxes=np.zeros((height // 2 + 1, 4), np.int64),
        unknown=np.zeros((height + 1, width + 1), np.int64),
        free=np.zeros((height + 1, width + 1), np.int64),
        layer=np.zeros(shape, np.uint8),
        patch=np.zeros(49, np.uint8),
        blocked=np.zeros(4, np.uint8),
        scan=new_scan(sensor.lidar),
    )
