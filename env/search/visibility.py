"""What every cell of a known map shows, as sets that can be joined and counted quickly.

A set of cells is one 64-bit word for each tile of 8x8 cells that it touches. A scan touches few tiles, so joining
the views along a way costs a few operations a step whatever the size of the map.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE, MOVES, UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.search.bfs import flood
from indoor_explorers.env.sensing.lidar import Optics, Scan, new_scan, visible_cells

#: Cells along one side of a tile.
TILE = 8


@kernel(inline="always")
def bit_count(word: np.uint64) -> np.uint64:
    """Count the ones of a 64-bit word (Warren, Hacker's Delight, 5-1)."""
    word -= (word >> np.uint64(1)) & np.uint64(0x5555555555555555)
    word = (word & np.uint64(0x3333333333333333)) + ((word >> np.uint64(2)) & np.uint64(0x3333333333333333))
    word = (word + (word >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return (word * np.uint64(0x0101010101010101)) >> np.uint64(56)


class Sights(NamedTuple):
    """The M cells that can be reached, numbered breadth-first from the starts, and what each shows."""

    cells: NDArray[np.int32]
    """(M,) their flat indices in the map."""
    near: NDArray[np.int32]
    """(M, 4) numbers of the neighbours, -1 for none."""
    first: NDArray[np.int64]
    """(M + 1,) where the words of each cell begin and, last, where the last ones end."""
    tile: NDArray[np.int32]
    """The tile of each word."""
    bits: NDArray[np.uint64]
    """The words: which of a tile's counted cells are seen."""
    all: NDArray[np.uint64]
    """(T,) what is seen from all M cells together; T is the number of tiles of the map."""


@leaf()
def _number(truth: np.ndarray, starts: np.ndarray, steps: np.ndarray, cells: np.ndarray, number: np.ndarray) -> int:
    """Number the cells that can be reached in ``number`` (H*W,), -1 at first; return how many they are.

    ``cells`` (H*W,) lists them. ``steps`` (H, W) is scratch, ``UNREACHABLE`` at first.
    """
    sources = 0
    for k in range(starts.shape[0]):
        row, col = divmod(starts[k], truth.shape[1])
        if steps[row, col] > 0:
            steps[row, col], cells[sources] = 0, starts[k]
            sources += 1
    count = flood(truth, FREE, sources, cells, steps)
    for k in range(count):
        number[cells[k]] = k
    return count


@leaf()
def _link(shape: tuple[int, int], number: np.ndarray, cells: np.ndarray, near: np.ndarray) -> None:
    height, width = shape
    for i in range(cells.shape[0]):
        row, col = divmod(cells[i], width)
        for k in range(4):
            r, c = row + MOVES[k, 0], col + MOVES[k, 1]
            inside = 0 <= r < height and 0 <= c < width
            near[i, k] = number[r * width + c] if inside else -1


@leaf()
def _look(
    truth: np.ndarray, cell: int, counts: np.ndarray, lens: Optics, scan: Scan, tiles: np.ndarray, words: np.ndarray
) -> int:
    """Add the counted cells seen from a flat cell to ``words`` (T,) and list their ``tiles``; return how many."""
    width = truth.shape[1]
    across = (width + TILE - 1) // TILE
    found = 0
    for place in range(visible_cells(truth, cell // width, cell % width, lens, scan)):
        seen = scan.cells[place]
        if counts[seen]:
            row, col = divmod(seen, width)
            tile = (row // TILE) * across + col // TILE
            if words[tile] == 0:
                tiles[found] = tile
                found += 1
            words[tile] |= np.uint64(1) << np.uint64(row % TILE * TILE + col % TILE)
    return found


@kernel()
def _sights(truth: np.ndarray, starts: np.ndarray, whole: bool, lens: Optics) -> Sights:
    height, width = truth.shape
    number, cells = np.full(truth.size, -1, np.int32), np.empty(truth.size, np.int32)
    steps = np.full(truth.shape, UNREACHABLE, np.int32)
    cells = cells[: _number(truth, starts, steps, cells, number)].copy()
    near = np.empty((cells.shape[0], 4), np.int32)
    _link((height, width), number, cells, near)
    total = ((height + TILE - 1) // TILE) * ((width + TILE - 1) // TILE)
    counts, scan = number >= (-1 if whole else 0), new_scan(lens)
    tiles, words, everything = np.empty(total, np.int32), np.zeros(total, np.uint64), np.zeros(total, np.uint64)
    first, size = np.zeros(cells.shape[0] + 1, np.int64), 0
    tile, bits = np.empty(1024, np.int32), np.empty(1024, np.uint64)
    for i in range(cells.shape[0]):
        found = _look(truth, cells[i], counts, lens, scan, tiles, words)
        if size + found > tile.shape[0]:
            tile, bits = np.append(tile, np.empty(size + found, np.int32)), np.append(bits, np.empty_like(bits))
            bits = np.append(bits, np.empty(tile.shape[0] - bits.shape[0], np.uint64))
        for k in range(found):
            word = tiles[k]
            tile[size], bits[size] = word, words[word]
            everything[word] |= words[word]
            words[word] = 0
            size += 1
        first[i + 1] = size
    return Sights(cells, near, first, tile[:size].copy(), bits[:size].copy(), everything)


def sights_of(truth: Belief, starts: Sequence[Cell], lens: Optics, *, whole: bool) -> Sights:
    """Return what can be seen of a true map (H, W) from all cells that can be reached from the starts.

    Counted are the cells that can be reached or, ``whole``, all cells of the map.
    """
    flat = np.array([row * truth.shape[1] + col for row, col in starts], np.int64)
    return Sights(*_sights(np.ascontiguousarray(truth), flat, whole, lens))


@leaf()
def look(sights: Sights, cell: int, seen: np.ndarray) -> int:
    """Add what cell number ``cell`` shows to ``seen`` (T,); return how many cells are new."""
    new = np.int64(0)
    for place in range(sights.first[cell], sights.first[cell + 1]):
        tile = sights.tile[place]
        word = sights.bits[place] & ~seen[tile]
        if word != 0:
            seen[tile] |= word
            new += np.int64(bit_count(word))
    return int(new)


@leaf()
def unseen_from(sights: Sights, cell: int, seen: np.ndarray) -> int:
    """Count the cells that cell number ``cell`` shows and that are not in ``seen`` (T,)."""
    new = np.int64(0)
    for place in range(sights.first[cell], sights.first[cell + 1]):
        new += np.int64(bit_count(sights.bits[place] & ~seen[sights.tile[place]]))
    return int(new)


@leaf()
def size_of(words: np.ndarray) -> int:
    """Count the cells of a set (T,)."""
    count = np.int64(0)
    for k in range(words.shape[0]):
        count += np.int64(bit_count(words[k]))
    return int(count)
