"""The cells in view from every cell of a known map, as sets with fast union and count.

A set of cells is one 64-bit word for each tile of 8x8 cells that it touches. A scan touches few tiles, so the union of
the views along a path costs a few operations a step on maps of any size.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell, read_only
from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.grid.levels import beside, degree, rise_of
from indoor_explorers.env.search.bfs import flood
from indoor_explorers.env.search.bitsets import bit_count
from indoor_explorers.env.sensing.lidar import LidarModel, Scan, new_scan, visible_cells

#: Cells along one side of a tile.
TILE = 8


class VisibilityTable(NamedTuple):
    """The M reachable cells, numbered breadth-first from the starts, and the cells in view from each."""

    cells: NDArray[np.int32]
    """(M,) their flat indices in the map."""
    neighbours: NDArray[np.int32]
    """(M, 4) numbers of the neighbours, -1 for none; (M, 6) where there are levels."""
    offsets: NDArray[np.int64]
    """(M + 1,) where the words of each cell begin and, last, where the last ones end."""
    tile: NDArray[np.int32]
    """The tile of each word."""
    bits: NDArray[np.uint64]
    """The words: which of a tile's counted cells are seen."""
    union: NDArray[np.uint64]
    """(T,) the cells in view from any of the M cells; T is the number of tiles of the map."""


@leaf(entry=False)
def _number(
    truth: np.ndarray, starts: np.ndarray, steps: np.ndarray, cells: np.ndarray, number: np.ndarray, rise: int
) -> int:
    """Number the cells that can be reached in ``number`` (H*W,), -1 at first; return how many they are.

    ``cells`` (H*W,) lists them. ``steps`` (H, W) is scratch, ``UNREACHABLE`` at first.
    """
    sources = 0
    for k in range(starts.shape[0]):
        row, col = divmod(starts[k], truth.shape[1])
        if steps[row, col] > 0:
            steps[row, col], cells[sources] = 0, starts[k]
            sources += 1
    count = flood(truth, FREE, sources, cells, steps, rise)
    for k in range(count):
        number[cells[k]] = k
    return count


@leaf(entry=False)
def _link(shape: tuple[int, int], number: np.ndarray, cells: np.ndarray, neighbours: np.ndarray, rise: int) -> None:
    height, width = shape
    for i in range(cells.shape[0]):
        row, col = divmod(cells[i], width)
        for k in range(degree(rise)):
            r, c = beside(row, col, k, rise)
            inside = 0 <= r < height and 0 <= c < width
            neighbours[i, k] = number[r * width + c] if inside else -1


@leaf(entry=False)
def _scan_into(
    truth: np.ndarray,
    cell: int,
    counts: np.ndarray,
    lidar: LidarModel,
    scan: Scan,
    tiles: np.ndarray,
    words: np.ndarray,
) -> int:
    """Add the counted cells seen from a flat cell to ``words`` (T,) and list their ``tiles``; return how many."""
    width = truth.shape[1]
    across = (width + TILE - 1) // TILE
    found = 0
    for place in range(visible_cells(truth, cell // width, cell % width, lidar, scan)):
        seen = scan.cells[place]
        if counts[seen]:
            row, col = divmod(seen, width)
            tile = (row // TILE) * across + col // TILE
            if words[tile] == 0:
                tiles[found] = tile
                found += 1
            words[tile] |= np.uint64(1) << np.uint64(row % TILE * TILE + col % TILE)
    return found


@kernel(entry=False)
def grown(words: np.ndarray, size: int) -> np.ndarray:
    """Return a copy of an array (K,) with room for ``size`` numbers, (size,)."""
    larger = np.empty(size, words.dtype)
    for k in range(words.shape[0]):
        larger[k] = words[k]
    return larger


@kernel()
def _fill_table(
    truth: np.ndarray,
    starts: np.ndarray,
    steps: np.ndarray,
    number: np.ndarray,
    count_all_cells: bool,
    lidar: LidarModel,
) -> VisibilityTable:
    """Return the table of :func:`visibility_table`; ``steps`` (H, W) and ``number`` (H*W,) as in :func:`_number`."""
    height, width = truth.shape
    cells = np.empty(truth.size, np.int32)
    rise = rise_of(height, lidar.volume.levels)
    cells = cells[: _number(truth, starts, steps, cells, number, rise)].copy()
    neighbours = np.empty((cells.shape[0], degree(rise)), np.int32)
    _link((height, width), number, cells, neighbours, rise)
    total = ((height + TILE - 1) // TILE) * ((width + TILE - 1) // TILE)
    counts, scan = number >= (-1 if count_all_cells else 0), new_scan(lidar)
    tiles, words, union = np.empty(total, np.int32), np.zeros(total, np.uint64), np.zeros(total, np.uint64)
    offsets, size = np.zeros(cells.shape[0] + 1, np.int64), 0
    tile, bits = np.empty(1024, np.int32), np.empty(1024, np.uint64)
    for i in range(cells.shape[0]):
        found = _scan_into(truth, cells[i], counts, lidar, scan, tiles, words)
        if size + found > tile.shape[0]:
            tile, bits = grown(tile, 2 * (size + found)), grown(bits, 2 * (size + found))
        for k in range(found):
            word = tiles[k]
            tile[size], bits[size] = word, words[word]
            union[word] |= words[word]
            words[word] = 0
            size += 1
        offsets[i + 1] = size
    return VisibilityTable(cells, neighbours, offsets, tile[:size].copy(), bits[:size].copy(), union)


def visibility_table(
    truth: Belief, starts: Sequence[Cell], lidar: LidarModel, *, count_all_cells: bool
) -> VisibilityTable:
    """Return the visibility table of a true map (H, W) for all cells that can be reached from the starts.

    Only reachable cells are counted or, with ``count_all_cells``, all cells of the map.
    """
    flat = np.array([row * truth.shape[1] + col for row, col in starts], np.int64)
    steps, number = np.full(truth.shape, UNREACHABLE, np.int32), np.full(truth.size, -1, np.int32)
    table = _fill_table(read_only(np.ascontiguousarray(truth)), flat, steps, number, count_all_cells, lidar)
    return VisibilityTable(*table)


@leaf()
def add_visible(table: VisibilityTable, cell: int, seen: np.ndarray) -> int:
    """Add the cells in view from cell number ``cell`` to ``seen`` (T,); return the number of new ones."""
    new = np.int64(0)
    for place in range(table.offsets[cell], table.offsets[cell + 1]):
        tile = table.tile[place]
        word = table.bits[place] & ~seen[tile]
        if word != 0:
            seen[tile] |= word
            new += np.int64(bit_count(word))
    return int(new)


@leaf()
def count_unseen(table: VisibilityTable, cell: int, seen: np.ndarray) -> int:
    """Count the cells in view from cell number ``cell`` that are not in ``seen`` (T,)."""
    new = np.int64(0)
    for place in range(table.offsets[cell], table.offsets[cell + 1]):
        new += np.int64(bit_count(table.bits[place] & ~seen[table.tile[place]]))
    return int(new)


@leaf()
def count_cells(words: np.ndarray) -> int:
    """Count the cells of a set (T,)."""
    count = np.int64(0)
    for k in range(words.shape[0]):
        count += np.int64(bit_count(words[k]))
    return int(count)
