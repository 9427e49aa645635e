"""Flown tracks whose staircases are straight lines, as UAVs that turn by any angle fly."""

from __future__ import annotations

from math import hypot

import numpy as np

from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.grid.lines import walls_between


@kernel()
def straightened(occupancy: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Return which cells (K,) of a track (S, 2) through a true map (H, W) uint8 stay as corners, the ends among them.

    A stretch of the track counts as the straight line between its ends while it moves along each axis one way only,
    and no obstacle is between. Stretches are as long as can be, from the start on. No detour is left out: the track
    still passes within the rectangle of each stretch, and turns back where it did. On the plane of several levels no
    stretch changes level, except straight up and down by one.
    """
    corners = np.zeros(cells.shape[0] + 1, np.int64)
    found, anchor = 1, 0
    down = right = 0
    for k in range(1, cells.shape[0]):
        step_down, step_right = cells[k, 0] - cells[k - 1, 0], cells[k, 1] - cells[k - 1, 1]
        turned = step_down * down < 0 or step_right * right < 0
        if turned or walls_between(occupancy, cells[anchor, 0], cells[anchor, 1], cells[k, 0], cells[k, 1]) > 0:
            if anchor != k - 1:
                corners[found] = k - 1
                found += 1
            anchor, down, right = k - 1, 0, 0
        if step_down != 0:
            down = step_down
        if step_right != 0:
            right = step_right
    corners[found] = cells.shape[0] - 1
    return corners[: found + 1]


@kernel()
def straightened_length(occupancy: np.ndarray, cells: np.ndarray) -> float:
    """Return the length in cells of a track (S, 2) that is :func:`straightened` on a true map (H, W) uint8."""
    total = 0.0
    corners = straightened(occupancy, cells)
    for k in range(1, corners.shape[0]):
        start, end = corners[k - 1], corners[k]
        total += hypot(cells[end, 0] - cells[start, 0], cells[end, 1] - cells[start, 1])
    return total
