"""A lidar with a limited field of view, and what unknown cells in view are worth to it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.sensing.field_of_view import least_cosine
from indoor_explorers.env.sensing.lidar import LidarModel, lidar_model
from indoor_explorers.planners.toolbox.information.candidates import UnknownWeight, cell_weight, depths


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
