"""Small random maps."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.maps.floorplan import Floorplan


def connected_map(seed: int, shape: tuple[int, int], share: float) -> tuple[Belief, list[Cell]]:
    """Return the largest connected part of a map with a share of obstacles, and its cells in random order."""
    rng = np.random.default_rng(seed)
    free = Floorplan(np.where(rng.random(shape) < share, 2, 1).astype(np.uint8), "noise").main_part
    cells = [(row, col) for row, col in rng.permutation(np.argwhere(free)).tolist()]
    return np.where(free, 1, 2).astype(np.uint8), cells
