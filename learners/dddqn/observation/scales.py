"""Constants of one lidar range and scratch arrays of one map shape for the compiled observation."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.sensing.lidar import LidarModel, Scan, lidar_model, new_scan

#: The lidar range, in cells, that distances and areas are scaled to: that of the thesis.
REFERENCE_RANGE = 3.0
#: Discount factors of the gain ahead, per step at the reference range.
DISCOUNTS = (0.7, 0.85, 0.95)


class Sensor(NamedTuple):
    """Constants of a lidar range; lengths are scaled by ``range / 3``."""

    lidar: LidarModel
    """The lidar."""
    reach: int
    """Largest row or column offset in range, in cells."""
    disc: float
    """Number of cells in range without the UAV's own: the most that one scan can reveal."""
    scale: int
    """Side of one pixel of the fine map in cells, odd; also the spacing of the lattice of view gains."""
    rate: float
    """Steps at the reference range per step: 3 / range."""
    decay: NDArray[np.float64]
    """(3,) discount factors of the gain ahead per step."""


class Scratch(NamedTuple):
    """Working arrays of one observation, for maps of one shape."""

    steps: NDArray[np.int32]
    """(H, W) distances in steps."""
    first: NDArray[np.uint8]
    """(H, W) the moves, one bit each, that begin a shortest path to a cell."""
    ahead: NDArray[np.float64]
    """(4, 5) the gains ahead of each move: the best for each discount, the sum, and the distance to the nearest."""
    power: NDArray[np.float64]
    """(3,) discount factors of the current distance."""
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
    """(49,) the 7x7 cells around one."""
    blocked: NDArray[np.uint8]
    """(4,) whether each move is blocked."""
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
