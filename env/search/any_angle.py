"""The length of a flown track whose staircases are straight lines, as UAVs that turn by any angle fly."""

from __future__ import annotations

from math import hypot

import numpy as np

from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.grid.lines import walls_between


@kernel()
def straightened_length(occupancy: np.ndarray, cells: np.ndarray) -> float:
    """Return the length in cells of a track (S, 2) through a true map (H, W) uint8, cut where it may be straightened.

    A stretch of the track counts as the straight line between its ends while it moves along each axis one way only,
    and no obstacle is between. Stretches are as long as can be, from the start on. No detour is left out: the track
    still passes within the rectangle of each stretch, and turns back where it did.
    """
    total, anchor = 0.0, 0
    down = right = 0
    for k in range(1, cells.shape[0]):
        step_down, step_right = cells[k, 0] - cells[k - 1, 0], cells[k, 1] - cells[k - 1, 1]
        turned = step_down * down < 0 or step_right * right < 0
        if turned or walls_between(occupancy, cells[anchor, 0], cells[anchor, 1], cells[k, 0], cells[k, 1]) > 0:
            total += hypot(cells[k - 1, 0] - cells[anchor, 0], cells[k - 1, 1] - cells[anchor, 1])
            anchor, down, right = k - 1, 0, 0
        if step_down != 0:
            down = step_down
        if step_right != 0:
            right = step_right
    last = cells.shape[0] - 1
    return total + hypot(cells[last, 0] - cells[anchor, 0], cells[last, 1] - cells[anchor, 1])
