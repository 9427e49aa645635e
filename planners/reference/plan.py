"""The plan of a team that knows the map: the cells that each UAV flies through.

It has two aims: a coverage, 99 % by default, and then the goal. A step after the first aim costs a tenth of
one before it. Measured on dungeons, rooms, offices, caves and mazes, 99 % is at most 1 % later than without the second
aim, and the goal is reached a quarter to a third earlier.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.search.visibility import (
    TILE,
    VisibilityTable,
    add_visible,
    count_cells,
    count_unseen,
    visibility_table,
)
from indoor_explorers.env.sensing.lidar import lidar_model
from indoor_explorers.planners.reference.annealing import anneal
from indoor_explorers.planners.reference.routes import Aims, DistanceTable, TeamState, tracks

#: Cost of a step after the first aim, relative to a step before it.
SHARE = 0.1
#: Largest size of the distance table in entries: on maps of more than 5,000 cells viewpoints are thinned out.
TABLE = 25_000_000
#: Hard limit of the table, one gigabyte: on larger maps, cells that the best viewpoints do not show are left out.
LARGEST_TABLE = 250_000_000

Track = tuple[Cell, ...]


class PlanRequest(NamedTuple):
    """The input of a plan, as hashable values."""

    truth: bytes
    """The true map."""
    shape: tuple[int, int]
    """(H, W)."""
    starts: tuple[Cell, ...]
    """Start cells of the UAVs."""
    lidar: tuple[float, str, int, float]
    """Range in cells, model, levels of the map and elevation: the arguments of
    :func:`~indoor_explorers.env.sensing.lidar.lidar_model`."""
    count_all_cells: bool
    """Whether coverage counts all cells of the map."""
    aim: float
    """Coverage to reach first; the goal if that is lower."""
    goal: float
    """Coverage to reach in the end."""
    known: bytes = b""
    """Which cells need not be seen, (H, W) bool; empty for none. If any are given, a coverage says which share of the
    reachable cells may be missing of the others."""
    others: Track = ()
    """Cells that other UAVs will be in; cells in view of them are not planned for."""


class SearchBudget(NamedTuple):
    """Effort of the search for a plan."""

    restarts: int
    """Number of searches; the best result is used."""
    changes: int
    """Changes of routes in each search."""
    work: int
    """Most word operations in each search."""


@kernel()
def _viewpoints(table: VisibilityTable, width: int, stride: int) -> np.ndarray:
    """Return which cells are viewpoints: those of a lattice, and others until they show every visible cell."""
    count = table.cells.shape[0]
    chosen, seen = np.zeros(count, np.bool_), np.zeros_like(table.union)
    for cell in range(count):
        row, col = divmod(table.cells[cell], width)
        if row % stride == 0 and col % stride == 0:
            chosen[cell] = True
            add_visible(table, cell, seen)
    for cell in range(count):
        chosen[cell] |= add_visible(table, cell, seen) > 0
    return chosen


@kernel()
def _best_viewpoints(table: VisibilityTable, most: int) -> np.ndarray:
    """Return which cells are viewpoints, at most ``most``: greedily those that add the most visible cells."""
    count = table.cells.shape[0]
    chosen, seen, least, found = np.zeros(count, np.bool_), np.zeros_like(table.union), count, 0
    while least > 0:
        for cell in range(count):
            if found < most and count_unseen(table, cell, seen) >= least:
                add_visible(table, cell, seen)
                chosen[cell] = True
                found += 1
        least //= 2
    return chosen


@kernel()
def _shown(table: VisibilityTable, cells: np.ndarray) -> int:
    """Count the cells that can be seen from some cells together."""
    seen = np.zeros_like(table.union)
    for cell in cells:
        add_visible(table, cell, seen)
    return count_cells(seen)


@kernel()
def _nearest(table: VisibilityTable, points: np.ndarray) -> np.ndarray:
    """Return the viewpoint nearest to each cell, (M,), by a breadth-first search from all viewpoints."""
    nearest, queue = np.full(table.cells.shape[0], -1, np.int32), np.empty(table.cells.shape[0], np.int32)
    head, tail = 0, points.shape[0]
    for k in range(tail):
        queue[k], nearest[points[k]] = points[k], k
    while head < tail:
        cell = queue[head]
        head += 1
        for k in range(table.neighbours.shape[1]):
            other = table.neighbours[cell, k]
            if other >= 0 and nearest[other] < 0:
                nearest[other] = nearest[cell]
                queue[tail] = other
                tail += 1
    return nearest


def _distance_table(table: VisibilityTable, width: int) -> DistanceTable:
    count = len(table.cells)
    stride = math.ceil(count / math.sqrt(TABLE))
    points = np.flatnonzero(_viewpoints(table, width, stride)).astype(np.int32)
    if len(points) * count > LARGEST_TABLE:
        points = np.flatnonzero(_best_viewpoints(table, LARGEST_TABLE // count)).astype(np.int32)
    steps, known = np.empty((len(points), count), np.int32), np.zeros(len(points), np.bool_)
    return DistanceTable(points, _nearest(table, points), steps, known, np.empty(count, np.int32))


@lru_cache(maxsize=32)
def plan(request: PlanRequest, budget: SearchBudget) -> tuple[Track, ...]:
    """Return the cells that each UAV flies through, its start first, without consecutive repetitions.

    This is a pure function; its result is cached for the other UAVs of the team.
    """
    height, width = request.shape
    truth = np.frombuffer(request.truth, np.uint8).reshape(request.shape)
    table = visibility_table(
        truth, request.starts, lidar_model(*request.lidar), count_all_cells=request.count_all_cells
    )
    number = {int(cell): k for k, cell in enumerate(table.cells)}
    seen = np.zeros_like(table.union)
    for cell in {row * width + col for row, col in request.others} & number.keys():
        add_visible(table, number[cell], seen)
    _add_known(seen, np.flatnonzero(np.frombuffer(request.known, np.bool_)), width)
    table.bits[:] &= ~seen[table.tile]
    distances = _distance_table(table, width)
    starts = np.array([number[row * width + col] for row, col in request.starts])
    state = TeamState(starts, starts.copy(), np.zeros_like(starts), np.zeros_like(table.union), np.zeros(1, np.int64))
    total = height * width if request.count_all_cells else len(table.cells)
    shown = _shown(table, np.concatenate([starts, distances.points]))
    levels = min(request.aim, request.goal), request.goal
    if request.known:
        first, last = (max(0, shown - math.floor((1.0 - level) * len(table.cells) + 1e-9)) for level in levels)
    else:
        first, last = (min(math.ceil(level * total - 1e-9), shown) for level in levels)
    if last == 0:
        return tuple((start,) for start in request.starts)
    aims = Aims(first, last, SHARE)
    found = [
        anneal(table, distances, state, aims, np.uint64(restart), budget.changes, budget.work)
        for restart in range(budget.restarts)
    ]
    routes, _ = min(found, key=lambda one: one[1])
    numbers = tracks(table, distances, routes, state, aims)
    flown = [table.cells[numbers[:, n]].tolist() for n in range(len(request.starts))]
    return tuple(tuple(divmod(cell, width) for cell in track) for track in swap_resolved(flown))


def _add_known(seen: NDArray[np.uint64], cells: NDArray[np.int64], width: int) -> None:
    """Add flat cells to a set (T,)."""
    rows, cols = np.divmod(cells, width)
    bits = np.uint64(1) << (rows % TILE * TILE + cols % TILE).astype(np.uint64)
    np.bitwise_or.at(seen, rows // TILE * -(-width // TILE) + cols // TILE, bits)


def swap_resolved(flown: Sequence[Sequence[int]]) -> list[list[int]]:
    """Let UAVs that would pass through each other exchange the remainders of their routes instead.

    ``flown`` holds each UAV's cell at every step. The team is in the same cells as before, one step later.
    """
    ways = [[track[0], *(b for a, b in pairwise(track) if a != b)] for track in flown]
    at = [0] * len(ways)
    while any(place + 1 < len(way) for place, way in zip(at, ways, strict=True)):
        ahead = {(way[k], way[k + 1]): n for n, (k, way) in enumerate(zip(at, ways, strict=True)) if k + 1 < len(way)}
        for (cell, following), n in ahead.items():
            m = ahead.get((following, cell), n)
            if m > n:
                rest, other = ways[n][at[n] + 2 :], ways[m][at[m] + 2 :]
                ways[n][at[n] + 1 :], ways[m][at[m] + 1 :] = other, rest
                at[n], at[m] = at[n] - 1, at[m] - 1
        at = [min(k + 1, len(way) - 1) for k, way in zip(at, ways, strict=True)]
    return ways
