"""Sets of cells as bits: flat cell u is bit u % 64 of word u // 64."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.compiled import inner
from indoor_explorers.env.grid.randomness import draw

#: (W,) words of a set of cells.
Bits = NDArray[np.uint64]
#: Row and column changes to the eight cells around one.
AROUND = ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1))
_ONE = np.uint64(1)


def packed(mask: Mask) -> Bits:
    """Return the cells where a (H, W) or flat mask is set, as bits."""
    cells = np.zeros(-(-mask.size // 64) * 64, np.bool_)
    cells[: mask.size] = mask.ravel()
    return np.packbits(cells, bitorder="little").view(np.uint64)


def unpacked(bits: Bits, size: int) -> Mask:
    """Return the flat mask (size,) of a set of cells."""
    return np.unpackbits(bits.view(np.uint8), bitorder="little")[:size].astype(np.bool_)


@lru_cache(maxsize=32)
def around(shape: tuple[int, int], radius: int = 1) -> NDArray[np.int32]:
    """Return the cells of the square around each cell of a (H, W) map, (H*W, (2 radius + 1)^2 - 1), -1 off the map."""
    side = range(-radius, radius + 1)
    changes = [(down, right) for down in side for right in side if down or right]
    rows, cols = np.divmod(np.arange(shape[0] * shape[1]), shape[1])
    cells = np.full((rows.size, len(changes)), -1, np.int32)
    for k, (down, right) in enumerate(changes):
        r, c = rows + down, cols + right
        inside = (r >= 0) & (r < shape[0]) & (c >= 0) & (c < shape[1])
        cells[inside, k] = r[inside] * shape[1] + c[inside]
    cells.setflags(write=False)
    return cells


@lru_cache(maxsize=32)
def hash_keys(count: int) -> NDArray[np.uint64]:
    """Return fixed random words, (count,): a set's hash is the exclusive or of its members' (Zobrist 1970)."""
    keys = np.array([draw(np.uint64(0), np.uint64(k)) for k in range(count)], np.uint64)
    keys.setflags(write=False)
    return keys


@inner()
def holds(words: np.ndarray, cell: int) -> bool:
    """Tell whether a set has a flat cell."""
    return bool((words[cell >> 6] >> np.uint64(cell & 63)) & _ONE)


@inner()
def insert(words: np.ndarray, cell: int) -> None:
    """Put a flat cell into a set."""
    words[cell >> 6] |= _ONE << np.uint64(cell & 63)


@inner()
def meet(first: np.ndarray, second: np.ndarray) -> bool:
    """Tell whether two sets have a cell in common."""
    common = np.uint64(0)
    for w in range(first.shape[0]):
        common |= first[w] & second[w]
    return bool(common != np.uint64(0))


@inner()
def within(first: np.ndarray, second: np.ndarray) -> bool:
    """Tell whether all cells of the first set are in the second."""
    outside = np.uint64(0)
    for w in range(first.shape[0]):
        outside |= first[w] & ~second[w]
    return bool(outside == np.uint64(0))
