"""The optimistic map of a small room: unknown cells are assumed free and transparent, except likely obstacles.

Cells that are nearly certainly not free and reachable, by the learned map prior, are assumed to be obstacles.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.cells import OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.compiled import leaf

#: Probability, times 255, below which an unknown cell is assumed to be an obstacle.
UNLIKELY = 40


@leaf()
def assume_obstacles(belief: np.ndarray, chance: np.ndarray, out: np.ndarray) -> bool:
    """Write a belief with the assumed obstacles into ``out`` (H, W); return whether any obstacles are known.

    ``chance`` (H, W) uint8 is the map prior's probability of the unknown cells, 255 standing for 1.
    """
    any_known = False
    for r in range(belief.shape[0]):
        for c in range(belief.shape[1]):
            unlikely = belief[r, c] == UNKNOWN and chance[r, c] < UNLIKELY
            any_known |= belief[r, c] == OCCUPIED
            out[r, c] = OCCUPIED if unlikely else belief[r, c]
    return any_known
