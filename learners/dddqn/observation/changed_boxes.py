"""Boxes around the cells that became known since the last observation; only what depends on them is recomputed."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.grid.compiled import inner, leaf


@inner()
def _note_row(belief: np.ndarray, noted: np.ndarray) -> tuple[int, int]:
    """Note the known cells of one row (W,); return the first newly known column and the one after the last."""
    first, after = belief.shape[0], 0
    for c in range(belief.shape[0]):
        if belief[c] != UNKNOWN and noted[c] == 0:
            noted[c], first, after = 1, min(first, c), c + 1
    return first, after


@leaf()
def note(belief: np.ndarray, noted: np.ndarray, boxes: np.ndarray) -> int:
    """Note the known cells of a belief (H, W); write ``boxes`` around the newly known ones and return their number.

    A box is (top, left, bottom, right), the last two exclusive; adjacent rows with changes share one box.
    ``boxes`` must have room for one box in every second row.
    """
    found, joined = 0, False
    for r in range(belief.shape[0]):
        changed = False
        for c in range(belief.shape[1]):  # without a branch, so that the loop is vectorised
            changed |= (belief[r, c] != UNKNOWN) & (noted[r, c] == 0)
        if changed:
            left, right = _note_row(belief[r], noted[r])
            if joined:
                left, right = min(left, boxes[found - 1, 1]), max(right, boxes[found - 1, 3])
            else:
                boxes[found, 0] = r
                found += 1
            boxes[found - 1, 1], boxes[found - 1, 2], boxes[found - 1, 3] = left, r + 1, right
        joined = changed
    return found
