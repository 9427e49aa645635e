"""View gains of poses: the unknown cells that a lidar with a limited field of view may show from a cell and heading.

A pose is a cell and a heading. Its sector is what the world's lidar shows there on a belief map whose unknown cells are
transparent: the cells in line of sight and in the field of view, and the eight neighbours, which proximity sensors show
whatever the heading (after A. Bircher et al., ICRA 2016, doi:10.1109/ICRA.2016.7487281, and M. Selin et al., RA-L 2019,
doi:10.1109/LRA.2019.2897343, who take the best sector of a viewpoint).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.sensing.field_of_view import is_in_view, least_cosine
from indoor_explorers.env.sensing.lidar import LidarModel, lidar_model, new_scan, visible_cells
from indoor_explorers.planners.toolbox.information.candidates import UnknownWeight, cell_weight, depths, shared_views

#: Headings of a UAV: the actions 0 to 3.
HEADINGS = 4


class Camera(NamedTuple):
    """A lidar with a field of view."""

    lidar: LidarModel
    least_cosine: float
    """Of the angle between the heading and a cell in view; below -1 for all around."""


def camera(lidar_range: float, degrees: float) -> Camera:
    """Return the constants of a lidar range in cells and a field of view in degrees."""
    return Camera(lidar_model(float(lidar_range)), least_cosine(degrees))


@kernel()
def unknown_weights(belief: np.ndarray, weight: UnknownWeight) -> np.ndarray:
    """Return the weight of each unknown cell of a (H, W) belief, (H*W,); 0 for known ones."""
    depth, queue = np.empty(belief.shape, np.int32), np.empty(belief.size, np.int32)
    depths(belief, queue, depth)
    value = np.zeros(belief.size)
    for cell in range(belief.size):
        if belief[cell // belief.shape[1], cell % belief.shape[1]] == UNKNOWN:
            value[cell] = cell_weight(belief, depth, cell, weight)
    return value


@kernel()
def heading_gains(belief: np.ndarray, cells: np.ndarray, value: np.ndarray, camera: Camera) -> np.ndarray:
    """Return the summed ``value`` (H*W,) of the cells in view from (K,) flat cells with each heading, (K, 4)."""
    width, scan = belief.shape[1], new_scan(camera.lidar)
    gains = np.zeros((cells.shape[0], HEADINGS))
    for k in range(cells.shape[0]):
        row, col = divmod(cells[k], width)
        for place in range(1, visible_cells(belief, row, col, camera.lidar, scan)):
            cell = scan.cells[place]
            if value[cell] == 0.0:
                continue
            for heading in range(HEADINGS):
                if is_in_view(camera.least_cosine, heading, cell // width - row, cell % width - col):
                    gains[k, heading] += value[cell]
    return gains


@kernel()
def pose_views(
    belief: np.ndarray, cells: np.ndarray, headings: np.ndarray, value: np.ndarray, camera: Camera
) -> tuple[np.ndarray, np.ndarray]:
    """Return the view gains of K poses, (K,), and the share of each view that each other pose has, (K, K).

    ``cells`` (K,) are flat, ``value`` (H*W,) is that of unknown cells and 0 elsewhere.
    """
    width, scan = belief.shape[1], new_scan(camera.lidar)
    lists = np.empty((cells.shape[0], camera.lidar.disc + 1), np.int32)
    sizes = np.zeros(cells.shape[0], np.int64)
    for k in range(cells.shape[0]):
        row, col = divmod(cells[k], width)
        for place in range(1, visible_cells(belief, row, col, camera.lidar, scan)):
            cell = scan.cells[place]
            ahead = is_in_view(camera.least_cosine, headings[k], cell // width - row, cell % width - col)
            if value[cell] > 0.0 and ahead:
                lists[k, sizes[k]] = cell
                sizes[k] += 1
    return shared_views(lists, sizes, value)


def shows_new(belief: Belief, cell: Cell, heading: int, camera: Camera) -> bool:
    """Tell whether a pose has unknown cells of a (H, W) belief in view."""
    value = (belief.ravel() == UNKNOWN).astype(np.float64)
    flat = np.array([cell[0] * belief.shape[1] + cell[1]], np.int32)
    gains: NDArray[np.float64] = heading_gains(belief, flat, value, camera)
    return bool(gains[0, heading] > 0.0)
