"""Walks through a known map as paths in a graph whose states remember the last few cells.

A step into a cell newly shows the cells in view from there that were not in view from the remembered cells nor from the
starts. A longer memory counts fewer cells twice and gives tighter bounds; an unlimited memory would be exact. This is a
state-space relaxation (Christofides, Mingozzi and Toth, "State-space relaxation procedures for the computation of
bounds to routing problems", Networks 11, 1981, doi:10.1002/net.3230110207).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.search.bitsets import bit_count
from indoor_explorers.env.search.visibility import VisibilityTable, grown


class WalkGraph(NamedTuple):
    """S states, of which the first N are the starts of N UAVs, and A steps between them, by source."""

    cells: NDArray[np.int32]
    """(S, K) numbers of the remembered cells, the current one first; -1 where the walk is shorter."""
    first: NDArray[np.int64]
    """(S + 1,) the first step from each state."""
    target: NDArray[np.int32]
    """(A,) the state that each step leads to."""
    offsets: NDArray[np.int64]
    """(A + 1,) where the shown cells of each step begin."""
    shown: NDArray[np.int32]
    """The newly shown cells, as places in ``unseen``."""
    unseen: NDArray[np.int32]
    """(K,) the cells that are not in view at first and that some step shows: 64 times the tile plus the bit there."""

    @property
    def sources(self) -> NDArray[np.int32]:
        """(A,) the state that each step comes from."""
        return np.repeat(np.arange(len(self.cells), dtype=np.int32), np.diff(self.first))


@kernel()
def _single_cells(table: VisibilityTable) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the cells, first steps and targets of the graph whose states are cells."""
    count, size = table.cells.shape[0], 0
    cells = np.empty((count, 1), np.int32)
    first, target = np.zeros(count + 1, np.int64), np.empty(table.neighbours.size, np.int32)
    for cell in range(count):
        cells[cell, 0] = cell
        for k in range(table.neighbours.shape[1]):
            if table.neighbours[cell, k] >= 0:
                target[size] = table.neighbours[cell, k]
                size += 1
        first[cell + 1] = size
    return cells, first, target[:size].copy()


@kernel()
def _longer(
    cells: np.ndarray, first: np.ndarray, target: np.ndarray, team: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the graph whose states are the starts and the steps of another one: they remember one cell more."""
    steps, memory = target.shape[0], cells.shape[1] + 1
    longer, size = np.full((team + steps, memory), -1, np.int32), 0
    start_of = np.empty(team + steps, np.int64)  # the state of the other graph in which the new state ends
    for n in range(team):
        longer[n, 0], start_of[n] = cells[n, 0], n
    for source in range(cells.shape[0]):
        for step in range(first[source], first[source + 1]):
            longer[team + step, 0], start_of[team + step] = cells[target[step], 0], target[step]
            longer[team + step, 1:] = cells[source]
    longer_first = np.zeros(team + steps + 1, np.int64)
    for state in range(team + steps):
        longer_first[state + 1] = longer_first[state] + first[start_of[state] + 1] - first[start_of[state]]
    longer_target = np.empty(longer_first[-1], np.int32)
    for state in range(team + steps):
        for step in range(first[start_of[state]], first[start_of[state] + 1]):
            longer_target[size] = team + step
            size += 1
    return longer, longer_first, longer_target


@leaf(entry=False)
def _keep_new(table: VisibilityTable, remembered: np.ndarray, cell: int, known: np.ndarray, words: np.ndarray) -> int:
    """Put what a cell shows beyond ``known`` (T,) and remembered cells (K,) into ``words`` (T,); return how many."""
    count = np.int64(0)
    for place in range(table.offsets[cell], table.offsets[cell + 1]):
        words[table.tile[place]] = table.bits[place] & ~known[table.tile[place]]
    for k in range(remembered.shape[0]):
        if remembered[k] >= 0:
            for place in range(table.offsets[remembered[k]], table.offsets[remembered[k] + 1]):
                words[table.tile[place]] &= ~table.bits[place]
    for place in range(table.offsets[cell], table.offsets[cell + 1]):
        count += np.int64(bit_count(words[table.tile[place]]))
    return int(count)


@kernel(entry=False)
def _numbered(shown: np.ndarray, size: int) -> np.ndarray:
    """Replace cells below ``size`` by their places in the list of all that occur, which is returned."""
    number, count = np.full(size, -1, np.int32), 0
    for cell in shown:
        number[cell] = 0
    for cell in range(size):
        if number[cell] == 0:
            number[cell] = count
            count += 1
    occurring = np.empty(count, np.int32)
    for cell in range(size):
        if number[cell] >= 0:
            occurring[number[cell]] = cell
    for k in range(shown.shape[0]):
        shown[k] = number[shown[k]]
    return occurring


@kernel()
def _news(
    table: VisibilityTable, known: np.ndarray, cells: np.ndarray, first: np.ndarray, target: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what each step newly shows, as offsets and places in a list, and the list."""
    offsets, shown = np.zeros(target.shape[0] + 1, np.int64), np.empty(8 * target.shape[0] + 1024, np.int32)
    words, size = np.zeros_like(known), 0
    for source in range(cells.shape[0]):
        for step in range(first[source], first[source + 1]):
            cell = cells[target[step], 0]
            count = _keep_new(table, cells[source], cell, known, words)
            if size + count > shown.shape[0]:
                shown = grown(shown, 2 * (size + count))
            for place in range(table.offsets[cell], table.offsets[cell + 1]):
                word = words[table.tile[place]]
                for bit in range(64 if word != 0 else 0):
                    if (word >> np.uint64(bit)) & np.uint64(1):
                        shown[size] = table.tile[place] * 64 + bit
                        size += 1
                words[table.tile[place]] = 0
            offsets[step + 1] = size
    shown = shown[:size].copy()
    return offsets, shown, _numbered(shown, 64 * known.shape[0])


def walk_graph(table: VisibilityTable, team: int, memory: int, known: NDArray[np.uint64]) -> WalkGraph:
    """Return the walks of ``team`` UAVs, which start in the first cells of a table and remember ``memory`` cells.

    ``known`` (T,) are the cells that do not count as new, with those in view from the starts.
    """
    graph = _single_cells(table)
    for _ in range(memory - 1):
        graph = _longer(*graph, team)
    return WalkGraph(*graph, *_news(table, known, *graph))
