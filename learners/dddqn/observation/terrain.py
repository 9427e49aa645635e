"""What can be seen from, and where one can go from, each cell of a room, as far as a UAV knows or has to assume.

Unknown cells are assumed to be free and transparent, unless the learned map prior is nearly certain that they do not
count: those are assumed to be obstacles.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.cells import MOVES, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.compiled import leaf
from indoor_explorers.env.sensing.lidar import visible_cells
from indoor_explorers.learners.dddqn.observation.bitboards import STRIDE, bit
from indoor_explorers.learners.dddqn.observation.scales import Scratch, Sensor

#: Unknown cells whose chance to count is below this, of 255, are assumed to be obstacles.
UNLIKELY = 40


@leaf()
def _see(belief: np.ndarray, row: int, col: int, sensor: Sensor, scratch: Scratch, view: np.ndarray) -> None:
    """Write what is visible from a cell, as bits (4,)."""
    view[:] = 0
    if belief[row, col] == OCCUPIED:
        return
    for k in range(visible_cells(belief, row, col, sensor.optics, scratch.scan)):
        r, c = divmod(scratch.scan.cells[k], belief.shape[1])
        view[(r * STRIDE + c) >> 6] |= bit(r * STRIDE + c)


@leaf()
def _connect(belief: np.ndarray, passages: np.ndarray) -> None:
    """List the neighbours of every cell that are not obstacles."""
    height, width = belief.shape
    passages[:] = -1
    for r in range(height):
        for c in range(width):
            for k in range(4):
                i, j = r + MOVES[k, 0], c + MOVES[k, 1]
                if 0 <= i < height and 0 <= j < width and belief[r, c] != OCCUPIED and belief[i, j] != OCCUPIED:
                    passages[r * STRIDE + c, k] = i * STRIDE + j


@leaf()
def keep_up(
    belief: np.ndarray,
    chance: np.ndarray,
    sensor: Sensor,
    scratch: Scratch,
    stale: np.ndarray,
    obstacles: np.ndarray,
    views: np.ndarray,
    passages: np.ndarray,
) -> bool:
    """Bring ``views`` and ``passages`` up to date with the obstacles; return whether any are known.

    ``chance`` (H, W) is that of the unknown cells to count, of 255; ``stale`` (16, 16) is scratch.
    """
    height, width = belief.shape
    reach, grown, any_known = sensor.reach + 1, False, False
    stale[:] = 0
    for r in range(height):
        for c in range(width):
            known = belief[r, c] == OCCUPIED
            now = known or (belief[r, c] == UNKNOWN and chance[r, c] < UNLIKELY)
            any_known |= known
            scratch.layer[r, c] = OCCUPIED if now else belief[r, c]
            if obstacles[r, c] != now:
                obstacles[r, c], grown = now, True
                top, left = max(0, r - reach), max(0, c - reach)
                stale[top : r + reach + 1, left : c + reach + 1] = 1
    if not grown:
        return any_known
    for r in range(height):
        for c in range(width):
            if stale[r, c]:
                _see(scratch.layer, r, c, sensor, scratch, views[r * STRIDE + c])
    _connect(scratch.layer, passages)
    return any_known
