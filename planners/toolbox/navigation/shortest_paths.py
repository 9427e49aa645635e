"""Breadth-first searches for shortest paths: to a goal, within a number of steps, and between all of some cells.

Cells are flat indices (row * width + column). Each search has a number of its own, so that its marks need no clearing
before the next one. ``blocked`` lists flat cells that a search must not enter, such as the cell of a teammate.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.grid.compiled import inner, kernel, leaf
from indoor_explorers.env.grid.levels import degree

#: (K,) flat cells.
Cells = NDArray[np.int32]


class SearchBuffers(NamedTuple):
    """Buffers of one pilot's searches on a map of H*W cells."""

    queue: Cells
    """(H*W,) cells in the order they were reached."""
    parent: Cells
    """(H*W,) the cell from which each one was reached, -1 for the start."""
    mark: Cells
    """(H*W,) the number of the search that reached a cell last, so that nothing needs clearing."""


@inner()
def begin(cell: int, buffers: SearchBuffers, number: int) -> None:
    """Begin search ``number`` at a flat cell."""
    buffers.mark[cell] = number
    buffers.parent[cell] = -1
    buffers.queue[0] = cell


@inner()
def block(blocked: np.ndarray, buffers: SearchBuffers, number: int) -> None:
    """Make search ``number`` leave out (K,) flat cells."""
    for k in range(blocked.shape[0]):
        buffers.mark[blocked[k]] = number


@inner()
def expand(
    cells: np.ndarray, width: int, cell: int, buffers: SearchBuffers, number: int, tail: int, rise: int = 0
) -> int:
    """Append the free neighbours of ``cell`` that search ``number`` has not reached; return the new tail.

    ``cells`` (H*W,) is the flat belief. The neighbours come in the order of the actions: down, left, up, right, and
    where there are levels, above and below.
    """
    col, above = np.uint32(cell) % np.uint32(width), rise * width
    inside = (
        cell + width < cells.shape[0],
        col > 0,
        cell >= width,
        col + 1 < width,
        cell + above < cells.shape[0],
        cell >= above,
    )
    for k in range(degree(rise)):
        neighbour = cell + (width, -1, -width, 1, above, -above)[k]
        if inside[k] and cells[neighbour] == FREE and buffers.mark[neighbour] != number:
            buffers.mark[neighbour] = number
            buffers.parent[neighbour] = cell
            buffers.queue[tail] = neighbour
            tail += 1
    return tail


@leaf()
def search_to(
    belief: np.ndarray, start: int, goal: int, blocked: np.ndarray, buffers: SearchBuffers, number: int, rise: int = 0
) -> bool:
    """Search a (H, W) belief from ``start`` until ``goal`` is reached; return whether it was.

    ``start`` and ``goal`` are flat cells, and so are the (K,) ones of ``blocked``, which are left out.
    """
    cells, width = belief.reshape(belief.size), belief.shape[1]
    block(blocked, buffers, number)
    barred = goal != start and buffers.mark[goal] == number
    begin(start, buffers, number)
    head, tail = 0, 1
    while head < tail and buffers.mark[goal] != number:
        tail = expand(cells, width, buffers.queue[head], buffers, number, tail, rise)
        head += 1
    return bool(buffers.mark[goal] == number and not barred)


@leaf()
def search_within(
    belief: np.ndarray, start: int, reach: int, blocked: np.ndarray, buffers: SearchBuffers, number: int, rise: int = 0
) -> int:
    """Fill ``buffers.queue`` with the cells at most ``reach`` steps from ``start``, nearest first; return how many.

    ``belief`` is (H, W); the (K,) flat cells of ``blocked`` are left out.
    """
    cells, width = belief.reshape(belief.size), belief.shape[1]
    block(blocked, buffers, number)
    begin(start, buffers, number)
    head, tail, steps = 0, 1, 0
    while head < tail and steps < reach:
        layer_end = tail
        while head < layer_end:
            tail = expand(cells, width, buffers.queue[head], buffers, number, tail, rise)
            head += 1
        steps += 1
    return tail


@kernel()
def path_to(parent: np.ndarray, goal: int) -> np.ndarray:
    """Return the L flat cells from the start of the last search to ``goal``, both included, (L,) int32.

    ``parent`` (H*W,) is that of :class:`SearchBuffers`.
    """
    length, cell = 0, goal
    while cell >= 0:
        length += 1
        cell = parent[cell]
    path = np.empty(length, np.int32)
    cell = goal
    for k in range(length - 1, -1, -1):
        path[k] = cell
        cell = parent[cell]
    return path


@leaf(entry=False)
def _measure(
    belief: np.ndarray, start: int, waiting: np.ndarray, missing: int, buffers: SearchBuffers, number: int, rise: int
) -> None:
    """Search until ``missing`` of the places that are ``waiting`` (H*W,) are reached; parents hold steps instead."""
    cells, width, steps = belief.reshape(belief.size), belief.shape[1], buffers.parent
    begin(start, buffers, number)
    steps[start] = 0
    missing -= waiting[start]
    head, tail = 0, 1
    while head < tail and missing > 0:
        cell, reached = buffers.queue[head], tail
        tail = expand(cells, width, cell, buffers, number, tail, rise)
        for place in range(reached, tail):
            neighbour = buffers.queue[place]
            steps[neighbour] = steps[cell] + 1
            missing -= waiting[neighbour]
        head += 1


@kernel(entry=False)
def _wanted(belief: np.ndarray, cells: np.ndarray, row: np.ndarray, waiting: np.ndarray) -> int:
    """Count in ``waiting`` (H*W,) the free cells to which ``row`` (K,) holds no steps yet; return how many."""
    missing = 0
    for j in range(cells.shape[0]):
        if row[j] < 0 and belief.flat[cells[j]] == FREE:
            waiting[cells[j]] += 1
            missing += 1
    return missing


@kernel()
def fill_distances(
    belief: np.ndarray, cells: np.ndarray, steps: np.ndarray, buffers: SearchBuffers, number: int, rise: int = 0
) -> None:
    """Replace the negative entries of ``steps`` (K, K) by the steps between (K,) flat cells.

    Makes searches ``number`` to ``number + K - 1``, the cells with most missing entries first; each stops when its
    entries are complete.
    """
    count = cells.shape[0]
    waiting, reached = np.zeros(belief.size, np.int32), np.zeros(count, np.bool_)
    order = np.argsort(np.sum(steps >= 0, axis=1), kind="mergesort")
    for turn in range(count):
        k = int(order[turn])
        missing, exhausted = _wanted(belief, cells, steps[k], waiting), False
        if missing and belief.flat[cells[k]] == FREE:
            _measure(belief, cells[k], waiting, missing, buffers, number + k, rise)
        for j in range(count):
            waiting[cells[j]], reached[j] = 0, buffers.mark[cells[j]] == number + k
            if steps[k, j] < 0:
                steps[k, j] = steps[j, k] = buffers.parent[cells[j]] if reached[j] else UNREACHABLE
                exhausted |= not reached[j]
        if exhausted:  # cells out of reach from here are so from every cell that this search reached
            for i in range(count):
                for j in range(count):
                    if reached[i] and not reached[j] and steps[i, j] < 0:
                        steps[i, j] = steps[j, i] = UNREACHABLE
