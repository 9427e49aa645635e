"""Sets of cells of rooms of up to 16x16 cells as four 64-bit words: cell (r, c) is bit 16 r + c."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.compiled import inner
from indoor_explorers.env.search.visibility import bit_count

#: Cells of the largest room, and a bitboard's columns and words.
ROOM, STRIDE, WORDS = 16, 16, 4
#: The cells of one word that are in no room's last and in no room's first column.
_NOT_LAST, _NOT_FIRST = np.uint64(0x7FFF7FFF7FFF7FFF), np.uint64(0xFFFEFFFEFFFEFFFE)
_ONE, _ROW, _REST = np.uint64(1), np.uint64(16), np.uint64(48)
_MIX = (
    np.uint64(0x9E3779B97F4A7C15),
    np.uint64(0xBF58476D1CE4E5B9),
    np.uint64(0x94D049BB133111EB),
    np.uint64(0xD6E8FEB86659FD93),
)
#: The words of a set.
Words = tuple[np.uint64, np.uint64, np.uint64, np.uint64]


@inner()
def bit(cell: int) -> np.uint64:
    """Return the bit of a cell in its word, which is ``cell >> 6``."""
    return _ONE << np.uint64(cell & 63)


@inner()
def count(words: Words) -> int:
    """Count the cells of a set."""
    a, b, c, d = words
    return int(np.int64(bit_count(a) + bit_count(b) + bit_count(c) + bit_count(d)))


@inner()
def _pairs(word: np.uint64, below: np.uint64) -> np.uint64:
    """Count the pairs with a first cell in a word; ``below`` is the set moved up by one row."""
    east, south = word & (word >> _ONE) & _NOT_LAST, word & below
    south_east, south_west = word & (below >> _ONE) & _NOT_LAST, word & (below << _ONE) & _NOT_FIRST
    return bit_count(east) + bit_count(south) + bit_count(south_east) + bit_count(south_west)


@inner()
def pairs(words: Words) -> int:
    """Count the unordered pairs of neighbours within a set, diagonal ones included."""
    a, b, c, d = words
    first = _pairs(a, a >> _ROW | b << _REST) + _pairs(b, b >> _ROW | c << _REST)
    return int(np.int64(first + _pairs(c, c >> _ROW | d << _REST) + _pairs(d, d >> _ROW)))


@inner()
def hash_of(words: Words) -> np.uint64:
    """Return a hash of a set."""
    a, b, c, d = words
    key = a * _MIX[0]
    key = ((key ^ (key >> np.uint64(32))) + b) * _MIX[1]
    key = ((key ^ (key >> np.uint64(29))) + c) * _MIX[2]
    key = ((key ^ (key >> np.uint64(32))) + d) * _MIX[3]
    return key ^ (key >> np.uint64(31))


@inner()
def without(cells: np.ndarray, seen: np.ndarray) -> Words:
    """Return the cells of one set (4,) that are not in another."""
    return (cells[0] & ~seen[0], cells[1] & ~seen[1], cells[2] & ~seen[2], cells[3] & ~seen[3])
