"""The thesis's random rooms: square obstacles thrown into an open rectangle (MarsExplorer's generator)."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.maps.floorplan import Floorplan


def thesis_room(
    rng: np.random.Generator,
    *,
    height: int = 16,
    width: int = 16,
    obstacles: int = 5,
    obstacle_size: tuple[int, int] = (3, 3),
    margin: int = 1,
) -> Floorplan:
    """Draw a room of (height, width) cells with ``obstacles`` rectangles in it.

    Each rectangle's sides are drawn from ``obstacle_size`` (both ends included), its upper left cell
    uniformly with at least ``margin`` cells to the upper and left and ``margin`` + 1 to the lower and
    right border, as the ancestor does; what hangs over the border is cut off, and rectangles may overlap.
    """
    free = np.ones((height, width), np.bool_)
    smallest, largest = obstacle_size
    for _ in range(obstacles):
        row = int(rng.integers(margin, max(height - 1 - margin, margin + 1)))
        col = int(rng.integers(margin, max(width - 1 - margin, margin + 1)))
        tall, wide = (int(side) for side in rng.integers(smallest, largest + 1, 2))
        free[row : row + tall, col : col + wide] = False
    return Floorplan.from_free(free, "thesis")
