"""The optimistic map of a small room: unknown cells are taken for free, unless the map prior says otherwise.

Those that are nearly certain not to count, by the learned prior, are assumed to be obstacles.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.cells import OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.compiled import leaf

#: Unknown cells whose chance to count is below this, of 255, are assumed to be obstacles.
UNLIKELY = 40


@leaf()
def assume_obstacles(belief: np.ndarray, chance: np.ndarray, out: np.ndarray) -> bool:
    """Write a belief with the assumed obstacles into ``out`` (H, W); return whether any obstacles are known.

    ``chance`` (H, W) is that of the unknown cells to count, of 255.
    """
    any_known = False
    for r in range(belief.shape[0]):
        for c in range(belief.shape[1]):
            unlikely = belief[r, c] == UNKNOWN and chance[r, c] < UNLIKELY
            any_known |= belief[r, c] == OCCUPIED
            out[r, c] = OCCUPIED if unlikely else belief[r, c]
    return any_known
