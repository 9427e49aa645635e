"""What lies on the straight line between two cells of a map."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.cells import OCCUPIED
from indoor_explorers.env.grid.compiled import leaf


@leaf()
def walls_between(occupancy: np.ndarray, row: int, col: int, to_row: int, to_col: int) -> int:
    """Count the walls that the segment between the centres of two cells crosses.

    A wall is a run of obstacles (H, W) uint8 along the way. Touching the corner of one is none, passing between
    two that touch at a corner is one, as for the lidar; and as there, both ends find the same.
    """
    down, right = (1 if to_row > row else -1), (1 if to_col > col else -1)
    height, width = abs(to_row - row), abs(to_col - col)
    rows = cols = walls = 0
    inside = occupancy[row, col] == OCCUPIED
    while rows < height or cols < width:
        # The next horizontal cell border is crossed at (2 rows + 1) / (2 height) of the way; compare without dividing.
        horizontal, vertical = (2 * rows + 1) * width, (2 * cols + 1) * height
        squeezed = False
        if horizontal == vertical:
            squeezed = (
                occupancy[row + down * (rows + 1), col + right * cols] == OCCUPIED
                and occupancy[row + down * rows, col + right * (cols + 1)] == OCCUPIED
            )
        rows += horizontal <= vertical
        cols += vertical <= horizontal
        solid = occupancy[row + down * rows, col + right * cols] == OCCUPIED
        walls += (solid or squeezed) and not inside
        inside = solid
    return walls


@leaf()
def obstacles_on_line(occupancy: np.ndarray, row: int, col: int, to_row: int, to_col: int) -> int:
    """Count the obstacles of a (H, W) uint8 map on the Bresenham line between two cells, without the first cell.

    Where the line passes between two cells, it takes the one farther from the first cell, so the two directions differ.
    """
    rows, cols = abs(to_row - row), abs(to_col - col)
    down, right = (1 if to_row > row else -1), (1 if to_col > col else -1)
    length, found = max(rows, cols), 0
    along_rows = along_cols = length  # in cells, times twice the length
    for _ in range(length):
        along_rows, along_cols = along_rows + 2 * rows, along_cols + 2 * cols
        if along_rows >= 2 * length:
            along_rows, row = along_rows - 2 * length, row + down
        if along_cols >= 2 * length:
            along_cols, col = along_cols - 2 * length, col + right
        found += occupancy[row, col] == OCCUPIED
    return found
