"""Sets of cells as bits: cell u is bit u % 64 of word u // 64.

Sets of any size are arrays of words (W,) and number cells by the map's width. Boards are sets in rooms of up to 16x16
cells: four words, a tuple in compiled code, with cell (r, c) as bit 16 r + c, so that shifts lead to neighbours.
Searches keep the hashes of the sets that they have met in a table (:func:`is_new`).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.compiled import inner, kernel
from indoor_explorers.env.grid.randomness import draw

#: (W,) words of a set of cells.
Bits = NDArray[np.uint64]
#: Row and column changes to the eight cells around one.
AROUND = ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1))
_ONE = np.uint64(1)

#: Side of the largest room that a board holds, in cells; a board's columns and words.
ROOM, STRIDE, WORDS = 16, 16, 4
#: The cells of one word that are not in a board's last, or first, column.
_NOT_LAST, _NOT_FIRST = np.uint64(0x7FFF7FFF7FFF7FFF), np.uint64(0xFFFEFFFEFFFEFFFE)
_ROW, _REST = np.uint64(16), np.uint64(48)
_MIX = (
    np.uint64(0x9E3779B97F4A7C15),
    np.uint64(0xBF58476D1CE4E5B9),
    np.uint64(0x94D049BB133111EB),
    np.uint64(0xD6E8FEB86659FD93),
)
#: Slots of a hash table in which a key may stand.
PROBES = 8
_HASH_SHIFT = np.uint64(20)
#: The words of a board.
Board = tuple[np.uint64, np.uint64, np.uint64, np.uint64]


@kernel(inline="always")
def bit_count(word: np.uint64) -> np.uint64:
    """Count the ones of a 64-bit word (Warren, Hacker's Delight, 5-1)."""
    word -= (word >> np.uint64(1)) & np.uint64(0x5555555555555555)
    word = (word & np.uint64(0x3333333333333333)) + ((word >> np.uint64(2)) & np.uint64(0x3333333333333333))
    word = (word + (word >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return (word * np.uint64(0x0101010101010101)) >> np.uint64(56)


@inner()
def lowest(word: np.uint64) -> int:
    """Return the number of the lowest one in a word that has one."""
    return int(np.int64(bit_count((word & (~word + _ONE)) - _ONE)))


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
    """Tell whether a set (W,) uint64 has a cell."""
    return bool((words[cell >> 6] >> np.uint64(cell & 63)) & _ONE)


@inner()
def insert(words: np.ndarray, cell: int) -> None:
    """Put a cell into a set (W,) uint64."""
    words[cell >> 6] |= _ONE << np.uint64(cell & 63)


@inner()
def remove(words: np.ndarray, cell: int) -> None:
    """Take a cell out of a set (W,) uint64."""
    words[cell >> 6] &= ~(_ONE << np.uint64(cell & 63))


@inner()
def intersect(first: np.ndarray, second: np.ndarray) -> bool:
    """Tell whether two sets (W,) uint64 have a cell in common."""
    common = np.uint64(0)
    for w in range(first.shape[0]):
        common |= first[w] & second[w]
    return bool(common != np.uint64(0))


@inner()
def is_subset(first: np.ndarray, second: np.ndarray) -> bool:
    """Tell whether all cells of the first set (W,) uint64 are in the second (W,)."""
    outside = np.uint64(0)
    for w in range(first.shape[0]):
        outside |= first[w] & ~second[w]
    return bool(outside == np.uint64(0))


@inner()
def board_size(words: Board) -> int:
    """Count the cells of a board."""
    a, b, c, d = words
    return int(np.int64(bit_count(a) + bit_count(b) + bit_count(c) + bit_count(d)))


@inner()
def _pairs(word: np.uint64, below: np.uint64) -> np.uint64:
    """Count the pairs with a first cell in a word; ``below`` is the set moved up by one row."""
    east, south = word & (word >> _ONE) & _NOT_LAST, word & below
    south_east, south_west = word & (below >> _ONE) & _NOT_LAST, word & (below << _ONE) & _NOT_FIRST
    return bit_count(east) + bit_count(south) + bit_count(south_east) + bit_count(south_west)


@inner()
def neighbour_pairs(words: Board) -> int:
    """Count the unordered pairs of neighbours within a board, diagonal ones included."""
    a, b, c, d = words
    first = _pairs(a, a >> _ROW | b << _REST) + _pairs(b, b >> _ROW | c << _REST)
    return int(np.int64(first + _pairs(c, c >> _ROW | d << _REST) + _pairs(d, d >> _ROW)))


@inner()
def board_hash(words: Board) -> np.uint64:
    """Return a hash of a board."""
    a, b, c, d = words
    key = a * _MIX[0]
    key = ((key ^ (key >> np.uint64(32))) + b) * _MIX[1]
    key = ((key ^ (key >> np.uint64(29))) + c) * _MIX[2]
    key = ((key ^ (key >> np.uint64(32))) + d) * _MIX[3]
    return key ^ (key >> np.uint64(31))


@inner()
def without(cells: np.ndarray, seen: np.ndarray) -> Board:
    """Return the cells of one set (4,) that are not in another, as a board."""
    return (cells[0] & ~seen[0], cells[1] & ~seen[1], cells[2] & ~seen[2], cells[3] & ~seen[3])


@inner()
def is_new(table: np.ndarray, key: np.uint64) -> bool:
    """Tell whether a hash table lacks a key, and insert it while there is room.

    ``table`` is (P,) uint64, P a power of two, and zero at first; keys are hashes, of which the lowest bit is ignored.
    A key whose slots are all taken by others counts as new every time.
    """
    last = np.uint64(table.shape[0] - 1)
    slot, key = (key >> _HASH_SHIFT) & last, key | _ONE
    for _ in range(PROBES):
        if table[slot] == key:
            return False
        if table[slot] == 0:
            table[slot] = key
            return True
        slot = (slot + _ONE) & last
    return True
