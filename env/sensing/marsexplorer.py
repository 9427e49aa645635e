"""MarsExplorer's lidar (Koutras et al. 2021, doi:10.3390/electronics10222751), for comparison with old results.

32 rays leave the sensor at equal angles. Each is sampled at 200 points from the sensor to the range, and each
point belongs to the nearest cell. A ray ends at the nearest obstacle cell that it meets, half a cell beyond
that cell's centre, so that the obstacle is seen; samples off the map are moved to its border. All cells
that the shortened rays touch are seen. Rays leak between obstacles that touch at a corner, and sight is not
symmetric.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import OCCUPIED
from indoor_explorers.env.grid.compiled import leaf

RAYS = 32
#: Points a ray, both ends included.
SAMPLES = 200
#: Cells that a ray goes on behind the centre of the obstacle that it hit.
OVERSHOOT = 0.5


def directions() -> NDArray[np.float64]:
    """Return the (32, 2) directions of the rays: change of row and of column a cell of length."""
    angles = np.linspace(0.0, 2.0 * np.pi, RAYS, endpoint=False)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


@leaf(entry=False)
def _cell_at(start: int, end: float, sample: int, cells: int) -> int:
    """Return the row or column of a sample between a start and an end, moved onto the map."""
    place = end if sample == SAMPLES - 1 else sample * ((end - start) / (SAMPLES - 1)) + start
    return int(min(max(np.rint(place), 0.0), cells - 1.0))


@leaf(entry=False)
def _length(occupancy: np.ndarray, row: int, col: int, reach: float, down: float, right: float) -> float:
    """Return the distance in cells from the sensor to the nearest obstacle on a ray, ``reach`` when there is none."""
    height, width = occupancy.shape
    length, missed = reach, True
    for sample in range(SAMPLES):
        r = _cell_at(row, row + reach * down, sample, height)
        c = _cell_at(col, col + reach * right, sample, width)
        if occupancy[r, c] == OCCUPIED:
            distance = sqrt((r - row) ** 2 + (c - col) ** 2)
            length, missed = (distance if missed else min(length, distance)), False
    return length


@leaf(entry=False)
def trace(occupancy: np.ndarray, row: int, col: int, reach: float, rays: np.ndarray, out: np.ndarray) -> int:
    """List in ``out`` the flat indices of the cells that the rays touch; return how many entries there are.

    ``occupancy`` (H, W) uint8; ``rays`` (K, 2) are :func:`directions`; the sensor's own cell comes first.
    """
    height, width = occupancy.shape
    seen = 1
    out[0] = row * width + col
    for k in range(rays.shape[0]):
        down, right = rays[k, 0], rays[k, 1]
        length = min(_length(occupancy, row, col, reach, down, right) + OVERSHOOT, reach)
        for sample in range(SAMPLES):
            r = _cell_at(row, row + length * down, sample, height)
            c = _cell_at(col, col + length * right, sample, width)
            if out[seen - 1] != r * width + c:
                out[seen] = r * width + c
                seen += 1
    return seen
