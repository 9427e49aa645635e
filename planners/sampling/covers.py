"""Greedy set covers: few viewpoints that together see all cells that any of many viewpoints sees."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.search.bitsets import bit_count


@kernel(entry=False)
def _new(bits: np.ndarray, left: np.ndarray) -> int:
    """Count the ones of a row of words that are also in ``left``."""
    count = np.uint64(0)
    for word in range(bits.shape[0]):
        count += bit_count(bits[word] & left[word])
    return int(count)


@kernel()
def distinct(bits: np.ndarray, overlap: float, most: int) -> np.ndarray:
    """Return the first ``most`` rows of (K, words) ``bits`` that overlap little with each row returned before.

    Two rows overlap little if they share at most ``overlap`` of the later row's ones.
    """
    picks = np.empty(min(most, bits.shape[0]), np.int64)
    size = 0
    for k in range(bits.shape[0]):
        if size == picks.shape[0]:
            break
        alike, few = False, overlap * _new(bits[k], bits[k])
        for j in range(size):
            alike |= _new(bits[k], bits[picks[j]]) > few
        if not alike:
            picks[size] = k
            size += 1
    return picks[:size]


@kernel(entry=False)
def _leaders(
    bits: np.ndarray, weights: np.ndarray, left: np.ndarray, bounds: np.ndarray, leaders: np.ndarray, least: int
) -> int:
    """Fill ``leaders`` with the rows that add most, the best first; return their number.

    Rows that add fewer than ``least`` ones are left out. ``bounds`` (K,) holds upper bounds of the weighted number of
    new ones of each row, and is updated where necessary.
    """
    found, size = 0, leaders.shape[0]
    for k in range(bits.shape[0]):
        worst = bounds[leaders[size - 1]] if found == size else 0.0
        if bounds[k] <= worst:
            continue
        added = _new(bits[k], left)
        bounds[k] = weights[k] * added if added >= least else 0.0
        if bounds[k] <= worst:
            continue
        place = min(found, size - 1)
        while place > 0 and bounds[leaders[place - 1]] < bounds[k]:
            leaders[place] = leaders[place - 1]
            place -= 1
        leaders[place] = k
        found = min(found + 1, size)
    return found


@kernel()
def greedy_cover(bits: np.ndarray, weights: np.ndarray, ranks: np.ndarray, least: int) -> tuple[np.ndarray, np.ndarray]:
    """Pick rows of (K, words) ``bits`` until no other adds ``least`` ones; return the picks and their added ones.

    Round k orders the rows by the number of their new ones times their positive ``weights`` (K,), and picks the row at
    position ``ranks[k]``, or the last one if there are fewer. There are at most as many rounds as ``ranks``.
    """
    left = np.zeros(bits.shape[1], np.uint64)
    for k in range(bits.shape[0]):
        left |= bits[k]
    bounds = np.full(bits.shape[0], np.inf)
    leaders = np.zeros(ranks.max() + 1 if ranks.shape[0] > 0 else 1, np.int64)
    picks, added = np.empty(ranks.shape[0], np.int64), np.empty(ranks.shape[0], np.int64)
    size = 0
    while size < ranks.shape[0]:
        found = _leaders(bits, weights, left, bounds, leaders, least)
        if found == 0:
            break
        pick = leaders[min(ranks[size], found - 1)]
        picks[size], added[size] = pick, _new(bits[pick], left)
        left &= ~bits[pick]
        size += 1
    return picks[:size], added[:size]
