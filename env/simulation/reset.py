"""The start of an episode, compiled: a random room, the spawns, the cells that coverage counts, and a cleared state.

A start is first prepared without changing any episode, and then carried out, which cannot fail.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import allocated
from indoor_explorers.env.grid.cells import MOVES, OCCUPIED
from indoor_explorers.env.grid.compiled import inner, kernel, leaf
from indoor_explorers.env.grid.levels import enter_between
from indoor_explorers.env.grid.randomness import Stream, below, stream_key, uniform
from indoor_explorers.env.maps.generators.thesis import Room, draw_room
from indoor_explorers.env.search.connected_parts import label_part, mark_largest_part
from indoor_explorers.env.simulation.engine import Engine
from indoor_explorers.env.simulation.home_base import place_base
from indoor_explorers.env.simulation.path_loss import MOST_FADING
from indoor_explorers.env.simulation.state import Rules, State
from indoor_explorers.env.simulation.step import begin

MAP, SPAWN, ORDER, RADIO, _, FAILURE = (int(stream) for stream in list(Stream)[:6])

#: Maps drawn for one seed before a scenario is given up as impossible.
MAX_ATTEMPTS = 100


class Starts(NamedTuple):
    """The prepared starts of K episodes."""

    truth: Annotated[NDArray[np.uint8], "K H W"]
    """1 free, 2 occupied."""
    cell: Annotated[NDArray[np.int64], "K N 2"]
    """Row and column of each spawn."""
    reachable: Annotated[NDArray[np.bool_], "K H W"]
    """Cells that can be reached from the spawns."""
    size: Annotated[NDArray[np.int64], "K"]
    """Number of those cells."""


def empty_starts(count: int, team: int, shape: tuple[int, int]) -> Starts:
    """Allocate the starts of ``count`` episodes."""
    return allocated(Starts, K=count, N=team, H=shape[0], W=shape[1])


class FloodScratch(NamedTuple):
    """Working arrays of floods on maps of one shape; not to be shared between threads."""

    part: Annotated[NDArray[np.int32], "H W"]
    """Number of the connected part that a free cell belongs to, 0 for obstacles and cells not reached."""
    queue: Annotated[NDArray[np.int32], "cells"]
    """Cells to flood from."""


def flood_scratch(shape: tuple[int, int]) -> FloodScratch:
    """Allocate the working arrays of floods."""
    return allocated(FloodScratch, H=shape[0], W=shape[1], cells=shape[0] * shape[1])


@leaf()
def is_attainable(
    count_all_cells: bool, goal: float, truth: np.ndarray, main: np.ndarray, size: int, team: int
) -> bool:
    """Tell whether a team fits into the ``size`` cells of a map's main part (H, W), and can reach the goal there.

    ``count_all_cells`` and ``goal`` are those of :class:`~indoor_explorers.env.simulation.state.Rules`.
    """
    if size < team:
        return False
    if not count_all_cells:
        return True
    height, width = truth.shape
    seen = size
    for row in range(height):
        for col in range(width):
            if truth[row, col] == OCCUPIED:
                for k in range(4):
                    r, c = row + MOVES[k, 0], col + MOVES[k, 1]
                    if 0 <= r < height and 0 <= c < width and main[r, c] > 0:
                        seen += 1
                        break
    return bool(seen >= goal * truth.size)


@leaf()
def place_team(
    key: np.uint64,
    clustered: bool,
    start: int,
    truth: np.ndarray,
    scratch: FloodScratch,
    out: np.ndarray,
    rise: int = 0,
) -> None:
    """Fill ``out`` (N, 2) with distinct cells of the main part that ``scratch.part`` marks with numbers above 0.

    Random cells, or, ``clustered``, those that a flood from ``start`` (a flat index, -1 for a random cell) meets first.
    """
    (height, width), size = truth.shape, 0
    for row in range(height):
        for col in range(width):
            scratch.queue[size] = row * width + col
            size += scratch.part[row, col] > 0
    if clustered:
        first = start if start >= 0 else scratch.queue[below(key, 0, size)]
        scratch.part[:] = 0
        label_part(truth, first // width, first % width, 1, scratch.part, scratch.queue, rise)
    for n in range(out.shape[0]):
        if not clustered:
            other = n + below(key, n, size - n)
            scratch.queue[n], scratch.queue[other] = scratch.queue[other], scratch.queue[n]
        out[n, 0], out[n, 1] = divmod(scratch.queue[n], width)


@inner()
def _clear(rules: Rules, state: State, b: int) -> None:
    """Reset everything that an episode changes, except the true map and the cells."""
    state.step[b] = 0
    state.team_covered[b] = 0
    state.union[b, :, :] = 0
    enter_between(state.union[b], rules.levels)  # which UAVs know from the start
    for n in range(state.end.shape[1]):
        state.end[b, n] = 0
        state.belief[b, n, :, :] = 0
        enter_between(state.belief[b, n], rules.levels)
        state.sensed[b, n, :, :] = False
        state.visited[b, n, :, :] = False
        state.discovery_log[b, n, :] = 0
        state.history[b, n, :] = -1
        state.covered[b, n] = state.sensed_count[b, n] = state.known[b, n] = 0
        state.discovered[b, n] = state.received[b, n] = state.idle[b, n] = 0
        state.path_length[b, n] = state.collisions[b, n] = state.blocked[b, n] = state.sent_bytes[b, n] = 0
        state.reward[b, n] = 0.0
        state.outbox[b, n, :] = 0.0
        state.outbox_size[b, n] = -1
        state.silent_until[b, n] = 0
        state.merged_up_to[b, n, :] = 0
        state.linked[b, n, :] = False
        state.last_received_step[b, n, :] = -1
        state.last_received_size[b, n, :] = -1
        state.last_received_cell[b, n, :, :] = 0
        state.last_received[b, n, :, :] = 0.0


@inner()
def _place(state: State, starts: Starts, k: int, b: int) -> None:
    """Put the true map and the spawns in place, cell by cell: numba compiles no copy of a whole array as quickly."""
    for row in range(state.truth.shape[1]):
        for col in range(state.truth.shape[2]):
            state.truth[b, row, col] = starts.truth[k, row, col]
    for n in range(state.cell.shape[1]):
        state.cell[b, n, 0], state.cell[b, n, 1] = starts.cell[k, n, 0], starts.cell[k, n, 1]


@inner()
def _count(rules: Rules, state: State, starts: Starts, k: int, b: int) -> None:
    """Set the cells that coverage counts, the goal and the budget, from the reachable cells."""
    height, width = state.counts.shape[1], state.counts.shape[2]
    for row in range(height):
        for col in range(width):
            state.counts[b, row, col] = rules.count_all_cells or starts.reachable[k, row, col]
    state.total[b] = height * width if rules.count_all_cells else starts.size[k]
    state.needed[b] = np.int64(np.ceil(rules.goal * state.total[b] - 1e-9))
    state.budget[b] = rules.budget if rules.budget > 0 else max(rules.least_budget, starts.size[k])


@kernel()
def start_episodes(
    engine: Engine, starts: Starts, episodes: np.ndarray, seeds: np.ndarray, first: int, last: int
) -> None:
    """Begin the episodes (K,) from ``first`` to ``last`` - 1 as their ``starts`` and seeds (K,) say."""
    rules, state, lidar, work = engine.rules, engine.state, engine.lidar, engine.work
    for k in range(first, last):
        b = episodes[k]
        _clear(rules, state, b)
        _place(state, starts, k, b)
        _count(rules, state, starts, k, b)
        place_base(rules, state, b)
        state.order_key[b] = stream_key(seeds[k], ORDER, 0)
        state.radio_key[b] = stream_key(seeds[k], RADIO, 0)
        fading_key = stream_key(seeds[k], RADIO, 1)
        for which in range(2):
            state.fading[b, which] = MOST_FADING * uniform(fading_key, which)
        state.failure_key[b] = stream_key(seeds[k], FAILURE, 0)
        begin(rules, state, lidar, work, b)


@kernel()
def mark_reachable(scratch: FloodScratch, starts: Starts, rise: int = 0) -> None:
    """Fill ``reachable`` and ``size`` of starts whose maps and spawns are in place."""
    for k in range(starts.size.shape[0]):
        scratch.part[:] = 0
        starts.size[k] = 0
        for n in range(starts.cell.shape[1]):
            row, col = starts.cell[k, n, 0], starts.cell[k, n, 1]
            if scratch.part[row, col] == 0:
                starts.size[k] += label_part(starts.truth[k], row, col, 1, scratch.part, scratch.queue, rise)
        _mark(starts.reachable[k], scratch.part)


@leaf(entry=False)
def _mark(reachable: np.ndarray, part: np.ndarray) -> None:
    """Fill ``reachable`` (H, W) with True where ``part`` (H, W) holds more than 0."""
    for row in range(part.shape[0]):
        for col in range(part.shape[1]):
            reachable[row, col] = part[row, col] > 0


class RoomTask(NamedTuple):
    """The task that a random room must be suitable for."""

    room: Room
    clustered: bool
    """Whether UAVs start next to each other."""
    count_all_cells: bool
    """Whether coverage counts all cells of the map."""
    goal: float
    """Coverage that must be attainable."""


@leaf(entry=False)
def _draw_attainable(task: RoomTask, truth: np.ndarray, scratch: FloodScratch, team: int, seed: int) -> int:
    """Draw the first attainable room of a seed and mark its main part; return that part's size, -1 for no room."""
    for attempt in range(MAX_ATTEMPTS):
        draw_room(task.room, stream_key(seed, MAP, attempt), truth)
        size = mark_largest_part(truth, scratch.part, scratch.queue)
        if is_attainable(task.count_all_cells, task.goal, truth, scratch.part, size, team):
            return size
    return -1


@kernel()
def draw_rooms(task: RoomTask, scratch: FloodScratch, starts: Starts, seeds: np.ndarray, first: int, last: int) -> int:
    """Fill the starts ``first`` to ``last`` - 1 with the random rooms and spawns of their seeds (K,).

    Returns the first start whose seed has no attainable room, ``last`` when there is no such start.
    """
    for k in range(first, last):
        size = _draw_attainable(task, starts.truth[k], scratch, starts.cell.shape[1], seeds[k])
        if size < 0:
            return k
        place_team(stream_key(seeds[k], SPAWN, 0), task.clustered, -1, starts.truth[k], scratch, starts.cell[k])
        _mark(starts.reachable[k], scratch.part)  # all spawns are in the main part
        starts.size[k] = size
    return last
