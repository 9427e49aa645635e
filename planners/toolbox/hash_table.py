"""Hash tables of what a search has met before, for compiled code."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.compiled import inner

#: Slots that a key may stand in.
PROBES = 8
_ONE, _SHIFT = np.uint64(1), np.uint64(20)


@inner()
def is_new(table: np.ndarray, key: np.uint64) -> bool:
    """Tell whether a key was not met before, and remember it while there is room for it.

    ``table`` is (P,) uint64, P a power of two, and zero at first; keys are hashes, of which the lowest bit is ignored.
    Where the slots of a key are taken by others it counts as new every time.
    """
    last = np.uint64(table.shape[0] - 1)
    slot, key = (key >> _SHIFT) & last, key | _ONE
    for _ in range(PROBES):
        if table[slot] == key:
            return False
        if table[slot] == 0:
            table[slot] = key
            return True
        slot = (slot + _ONE) & last
    return True
