"""The spanning-tree bound on the steps of a team: it must look into each of several groups of cells.

A team that may miss k counted cells must see at least one of any k + 1. So for every group of k + 1 cells it must
enter the region from which at least one of them can be seen. The paths of N UAVs, their starts taken as one place,
connect all those regions; so their total length is at least that of a minimum spanning tree over the distances between
regions, and the longest path is at least an N-th of that. Distances inside a region count as 0, and each edge may end
in another cell of a region: both only make the tree shorter.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.search.bfs import flood_table
from indoor_explorers.env.search.visibility import TILE, VisibilityTable, add_visible

#: Limits of the effort: groups, and words of visibility that are read for them.
GROUPS, WORDS = 32, 3_000_000
#: Steps to a cell that cannot be reached.
FAR = np.int32(2**30)


def spanning_tree_bound(table: VisibilityTable, width: int, team: int, missable: int) -> int:
    """Return a bound on the steps of a team that may miss ``missable`` of the counted cells of a map of that width.

    The first ``team`` cells of ``table`` are the starts. Each group is around the cell that is
    seen last from the regions of the groups before; the bound holds for any groups.
    """
    if missable >= len(table.cells):
        return 0
    groups = min(GROUPS, max(2, WORDS // len(table.bits)))
    between = _between(table, width, team, missable + 1, groups)
    return math.ceil(_longest_tree(between) / team)


@kernel(entry=False)
def _flood(table: VisibilityTable, region: np.ndarray, steps: np.ndarray, queue: np.ndarray) -> int:
    """Fill ``steps`` (M,) with the steps from a region (M,) bool; return how many cells are reached, first in queue."""
    sources = 0
    for cell in range(region.shape[0]):
        steps[cell] = FAR
        if region[cell]:
            steps[cell] = 0
            queue[sources] = cell
            sources += 1
    return int(flood_table(table.neighbours, sources, queue, steps))


@kernel(entry=False)
def _seen_last(table: VisibilityTable, width: int, number: np.ndarray, order: np.ndarray) -> int:
    """Return the number of the counted cell that is seen last in the order, or of the cell that sees it."""
    seen, last = np.zeros_like(table.union), order[0]
    across = (width + TILE - 1) // TILE
    for cell in order:
        for place in range(table.offsets[cell], table.offsets[cell + 1]):
            new = table.bits[place] & ~seen[table.tile[place]]
            if new != 0:
                bit = 0
                while (new >> np.uint64(bit)) & np.uint64(1) == 0:
                    bit += 1
                row, col = divmod(table.tile[place], across)
                found = number[(row * TILE + bit // TILE) * width + col * TILE + bit % TILE]
                last = found if found >= 0 else cell
        add_visible(table, cell, seen)
    return int(last)


@kernel(entry=False)
def _group(
    table: VisibilityTable, width: int, middle: int, size: int, queue: np.ndarray, steps: np.ndarray
) -> np.ndarray:
    """Return the ``size`` cells nearest to a cell as words (T,)."""
    alone, words = np.zeros(table.cells.shape[0], np.bool_), np.zeros_like(table.union)
    alone[middle] = True
    reached = _flood(table, alone, steps, queue)
    if reached < size:
        return words
    across = (width + TILE - 1) // TILE
    for k in range(size):
        row, col = divmod(table.cells[queue[k]], width)
        words[row // TILE * across + col // TILE] |= np.uint64(1) << np.uint64(row % TILE * TILE + col % TILE)
    return words


@leaf(entry=False)
def _sees(table: VisibilityTable, cell: int, words: np.ndarray) -> bool:
    for place in range(table.offsets[cell], table.offsets[cell + 1]):
        if table.bits[place] & words[table.tile[place]] != 0:
            return True
    return False


@kernel(entry=False)
def _nearest_first(steps: np.ndarray) -> np.ndarray:
    """Return the numbers of cells in order of their steps (M,), those of equal steps in order of their numbers.

    Steps are small, so they are counted: that takes numba a tenth of the time to compile that a sort does.
    """
    places = np.zeros(steps.shape[0] + 1, np.int64)  # no shortest path has more steps than there are other cells
    for cell in range(steps.shape[0]):
        places[steps[cell] + 1] += 1
    for k in range(1, places.shape[0]):
        places[k] += places[k - 1]
    order = np.empty(steps.shape[0], np.int64)
    for cell in range(steps.shape[0]):
        order[places[steps[cell]]] = cell
        places[steps[cell]] += 1
    return order


@leaf(entry=False)
def _least(steps: np.ndarray, region: np.ndarray) -> int:
    """Return the fewest of the steps (M,) to cells of a region (M,) bool; ``FAR`` if that has none."""
    nearest = FAR
    for cell in range(region.shape[0]):
        if region[cell]:
            nearest = min(nearest, steps[cell])
    return int(nearest)


def _between(table: VisibilityTable, width: int, team: int, size: int, groups: int) -> NDArray[np.int64]:
    """Return the steps between the starts, taken as one place, and the regions of groups of ``size`` cells, (G, G)."""
    number = np.full(len(table.union) * TILE * TILE, -1, np.int64)
    number[table.cells] = np.arange(len(table.cells))
    least, between = np.full(len(table.cells), FAR, np.int32), np.zeros((groups + 1, groups + 1), np.int64)
    places = _fill_between(table, width, team, size, number, least, between)
    return np.ascontiguousarray(between[:places, :places])


@kernel()
def _fill_between(
    table: VisibilityTable, width: int, team: int, size: int, number: np.ndarray, least: np.ndarray, between: np.ndarray
) -> int:
    """Fill ``between`` (G, G); return how many rows of it, as groups may run out.

    ``number`` is that of each flat cell in the table, -1 for none; ``least`` (M,) is ``FAR`` at first.
    """
    count, groups = table.cells.shape[0], between.shape[0] - 1
    regions = np.zeros((groups + 1, count), np.bool_)
    steps, queue = np.empty(count, np.int32), np.empty(count, np.int32)
    regions[0, :team] = True
    for made in range(groups + 1):
        _flood(table, regions[made], steps, queue)
        for cell in range(count):
            least[cell] = min(least[cell], steps[cell])
        for other in range(made):
            between[made, other] = between[other, made] = _least(steps, regions[other])
        if made == groups:
            break
        middle = _seen_last(table, width, number, _nearest_first(least))
        words = _group(table, width, middle, size, queue, steps)
        for cell in range(count):
            regions[made + 1, cell] = _sees(table, cell, words)
        nearest = _least(least, regions[made + 1])
        if nearest == 0 or nearest == FAR:
            return int(made + 1)
    return int(groups + 1)


@kernel()
def _longest_tree(between: np.ndarray) -> int:
    """Return the length of the longest of the minimum spanning trees of the first 2, 3, ... of G groups (Prim 1957).

    ``between`` are their (G, G) distances, the same in both directions.
    """
    longest = 0
    nearest = np.empty(between.shape[0], np.int64)
    for count in range(2, between.shape[0] + 1):
        length = 0
        for group in range(count):
            nearest[group] = between[0, group]
        nearest[0] = -1  # it is in the tree
        for _ in range(count - 1):
            added = -1
            for group in range(count):
                if nearest[group] >= 0 and (added < 0 or nearest[group] < nearest[added]):
                    added = group
            length += nearest[added]
            nearest[added] = -1
            for group in range(count):
                nearest[group] = min(nearest[group], between[added, group])
        longest = max(longest, length)
    return longest
