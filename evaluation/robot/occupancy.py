"""Occupancy grids of a robot as beliefs on cells of another size, conservative about obstacles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.interfaces import GridFrame
from indoor_explorers.env.interfaces.ros import FREE_UP_TO, OCCUPIED_FROM

#: Most cells of a map, and most samples a side that the known share of a cell is counted from.
MOST_CELLS, MOST_SAMPLES = 1_000_000, 8
#: Least share of a cell that is known to be free where the cell counts as free.
FREE_SHARE = 0.5
#: Metres around a map where the area to explore is not given: room to grow before pilots are made anew.
MARGIN = 10.0


class Area(NamedTuple):
    """A rectangle in the frame of the map, in metres."""

    x0: float
    y0: float
    x1: float
    y1: float

    def with_margin(self, margin: float) -> Area:
        """Return the rectangle with a margin all around."""
        return Area(self.x0 - margin, self.y0 - margin, self.x1 + margin, self.y1 + margin)


@dataclass(frozen=True)
class Occupancy:
    """An occupancy grid in the frame of its map."""

    values: NDArray[np.int8]
    """(h, w): -1 unknown, else the probability of an obstacle in percent; the first row lies at the origin."""
    resolution: float
    """Metres a pixel."""
    origin: tuple[float, float, float]
    """(x, y, yaw) of the outer corner of the first pixel, in metres and radians."""

    def pixels(self, x: ArrayLike, y: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return points in metres as fractional (column, row) of the grid."""
        x0, y0, yaw = self.origin
        right, up = np.asarray(x, np.float64) - x0, np.asarray(y, np.float64) - y0
        cos, sin = math.cos(yaw) / self.resolution, math.sin(yaw) / self.resolution
        return cos * right + sin * up, cos * up - sin * right

    def points(self, cols: ArrayLike, rows: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return fractional columns and rows as (x, y) in metres."""
        x0, y0, yaw = self.origin
        right, up = np.asarray(cols) * self.resolution, np.asarray(rows) * self.resolution
        cos, sin = math.cos(yaw), math.sin(yaw)
        return x0 + cos * right - sin * up, y0 + sin * right + cos * up

    def values_at(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.int8]:
        """Return the occupancies at points in metres; -1 off the grid."""
        cols, rows = (np.floor(part).astype(np.int64) for part in self.pixels(x, y))
        height, width = self.values.shape
        inside = (rows >= 0) & (rows < height) & (cols >= 0) & (cols < width)
        found = np.full(inside.shape, -1, np.int8)
        found[inside] = self.values[rows[inside], cols[inside]]
        return found

    def bounds(self) -> Area:
        """Return the rectangle around the grid."""
        height, width = self.values.shape
        x, y = self.points([0, width, 0, width], [0, 0, height, height])
        return Area(float(x.min()), float(y.min()), float(x.max()), float(y.max()))

    def is_within(self, frame: GridFrame) -> bool:
        """Tell whether all known pixels are on a frame."""
        rows, cols = np.nonzero(self.values >= 0)
        if len(rows) == 0:
            return True
        left, right, low, high = cols.min(), cols.max() + 1, rows.min(), rows.max() + 1
        x, y = self.points([left, right, left, right], [low, low, high, high])
        x, y = (x - frame.origin[0]) / frame.resolution, (y - frame.origin[1]) / frame.resolution
        return bool(min(x.min(), y.min()) >= 0 and x.max() <= frame.shape[1] and y.max() <= frame.shape[0])


def yaw_of(turn: Any) -> float:
    """Return the rotation about z of a ``geometry_msgs/Quaternion``, in radians."""
    return math.atan2(2 * (turn.w * turn.z + turn.x * turn.y), 1 - 2 * (turn.y**2 + turn.z**2))


def occupancy_of(grid: Any) -> Occupancy:
    """Return a ``nav_msgs/OccupancyGrid``, or what has its fields, checked.

    Raises:
        InputError: it is empty, tilted, or its numbers do not fit each other.

    """
    info, corner = grid.info, grid.info.origin
    values = np.asarray(grid.data, np.int8)
    if values.size == 0 or values.size != info.width * info.height:
        raise InputError(f"expected a map of {info.width} x {info.height} pixels, got {values.size} values")
    numbers = (info.resolution, corner.position.x, corner.position.y)
    if not all(map(math.isfinite, numbers)) or info.resolution <= 0:
        raise InputError(f"expected a map with a resolution above 0 and an origin in metres, got {numbers}")
    if max(abs(corner.orientation.x), abs(corner.orientation.y)) > 1e-3:
        raise InputError("expected a map that is turned about z alone, got an origin that is tilted; level it")
    pose = float(corner.position.x), float(corner.position.y), yaw_of(corner.orientation)
    return Occupancy(values.reshape(info.height, info.width), float(info.resolution), pose)


def frame_on(area: Area, cell: float) -> GridFrame:
    """Return the frame of the cells that cover an area; borders of cells are at multiples of ``cell`` metres.

    Raises:
        InputError: they are too many.

    """
    left, low = math.floor(area.x0 / cell + 1e-6), math.floor(area.y0 / cell + 1e-6)
    width = max(math.ceil(area.x1 / cell - 1e-6) - left, 1)
    height = max(math.ceil(area.y1 / cell - 1e-6) - low, 1)
    if width * height > MOST_CELLS:
        raise InputError(
            f"expected at most {MOST_CELLS} cells, got {height} x {width} of {cell:g} m; choose larger cells or --area"
        )
    return GridFrame(shape=(height, width), resolution=cell, origin=(left * cell, low * cell))


def belief_on(frame: GridFrame, grid: Occupancy, radius: float) -> Belief:
    """Return the (H, W) belief of a grid on the cells of a frame, for a robot of some radius in metres.

    A cell is occupied if an obstacle is nearer to its centre than the radius and half a cell: so no obstacle lies
    between the centres of two free cells side by side, nor in the way of a robot that drives from one to the other. It
    is free if it is not occupied, its centre is known to be free, and so is half of its area; else unknown.

    Raises:
        InputError: the cells are smaller than the grid's pixels.

    """
    cell = frame.resolution
    if cell < grid.resolution * (1 - 1e-3):
        raise InputError(
            f"expected cells of at least the map's {grid.resolution:g} m, got {cell:g}; make --cell larger"
        )
    samples = min(max(round(cell / grid.resolution), 1), MOST_SAMPLES)
    free = _free_at(frame, grid, samples).reshape(frame.shape[0], samples, frame.shape[1], samples)
    known = (free.mean(axis=(1, 3)) >= FREE_SHARE) & _free_at(frame, grid, 1)
    near = _near_obstacles(frame, grid, max(radius, cell / 2))
    return np.where(near, OCCUPIED, np.where(known, FREE, UNKNOWN)).astype(np.uint8)


def _free_at(frame: GridFrame, grid: Occupancy, samples: int) -> Mask:
    """Return whether points are known to be free, (H * samples, W * samples), the upper row first."""
    height, width = frame.shape
    step = frame.resolution / samples
    x = frame.origin[0] + (np.arange(width * samples) + 0.5) * step
    y = frame.origin[1] + (np.arange(height * samples)[::-1] + 0.5) * step
    values = grid.values_at(*np.meshgrid(x, y))
    return (values >= 0) & (values <= FREE_UP_TO)


def _near_obstacles(frame: GridFrame, grid: Occupancy, reach: float) -> Mask:
    """Return which cells have an obstacle nearer to their centre than ``reach`` metres, (H, W)."""
    (height, width), cell = frame.shape, frame.resolution
    rows, cols = np.nonzero(grid.values >= OCCUPIED_FROM)
    x, y = grid.points(cols + 0.5, rows + 0.5)
    right = np.floor((x - frame.origin[0]) / cell).astype(np.int64)
    up = np.floor((y - frame.origin[1]) / cell).astype(np.int64)
    near = np.zeros((height, width), np.bool_)
    span = math.ceil((reach + grid.resolution) / cell)
    for down in range(-span, span + 1):
        for aside in range(-span, span + 1):
            col, row = right + aside, up + down
            u, v = grid.pixels(frame.origin[0] + (col + 0.5) * cell, frame.origin[1] + (row + 0.5) * cell)
            away = np.hypot(np.maximum(abs(u - cols - 0.5) - 0.5, 0), np.maximum(abs(v - rows - 0.5) - 0.5, 0))
            hit = (away * grid.resolution < reach - 1e-6) & (row >= 0) & (row < height) & (col >= 0) & (col < width)
            near[height - 1 - row[hit], col[hit]] = True
    return near
