"""How an episode opens, compiled: the part of the map that counts, the spawns, and a state set back to zero."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import MOVES, OCCUPIED
from indoor_explorers.env.grid.compiled import inner, kernel, leaf
from indoor_explorers.env.grid.randomness import Stream, below, stream_key
from indoor_explorers.env.maps.generators.thesis import Room, draw_room
from indoor_explorers.env.search.connected_parts import label_part, mark_largest_part
from indoor_explorers.env.sensing.lidar import Optics
from indoor_explorers.env.simulation.engine import Engine, Work
from indoor_explorers.env.simulation.state import Rules, State
from indoor_explorers.env.simulation.step import begin

MAP, SPAWN, ORDER, RADIO = (int(stream) for stream in (Stream.MAP, Stream.SPAWN, Stream.ORDER, Stream.RADIO))

#: Maps drawn for one seed before a scenario is given up as impossible.
MAX_ATTEMPTS = 100


class Ground(NamedTuple):
    """Working arrays of an opening, for maps of one shape."""

    part: NDArray[np.int32]
    """(H, W) number of the connected part that a free cell belongs to, 0 for obstacles and what was not reached."""
    queue: NDArray[np.int32]
    """(H*W,) flood queue."""


def new_ground(shape: tuple[int, int]) -> Ground:
    """Allocate the working arrays of openings."""
    return Ground(np.zeros(shape, np.int32), np.zeros(shape[0] * shape[1], np.int32))


@leaf()
def is_attainable(rules: Rules, truth: np.ndarray, main: np.ndarray, size: int, team: int) -> bool:
    """Tell whether a team fits into the ``size`` cells of a map's main part (H, W), and can reach the goal there."""
    if size < team:
        return False
    if not rules.counts_map:
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
    return bool(seen >= rules.goal * truth.size)


@leaf()
def place_team(key: np.uint64, clustered: bool, start: int, truth: np.ndarray, ground: Ground, out: np.ndarray) -> None:
    """Fill ``out`` (N, 2) with distinct cells of the main part that ``ground.part`` marks with numbers above 0.

    Random cells, or, ``clustered``, those that a flood from ``start`` (a flat index, -1 for a random cell) meets first.
    """
    (height, width), size = truth.shape, 0
    for row in range(height):
        for col in range(width):
            ground.queue[size] = row * width + col
            size += ground.part[row, col] > 0
    if clustered:
        first = start if start >= 0 else ground.queue[below(key, 0, size)]
        ground.part[:] = 0
        label_part(truth, first // width, first % width, 1, ground.part, ground.queue)
    for n in range(out.shape[0]):
        if not clustered:
            other = n + below(key, n, size - n)
            ground.queue[n], ground.queue[other] = ground.queue[other], ground.queue[n]
        out[n, 0], out[n, 1] = divmod(ground.queue[n], width)


@inner()
def _clear(state: State, b: int) -> None:
    """Set back all that an episode changes, but the true map and the cells."""
    state.step[b] = 0
    state.team_covered[b] = 0
    state.union[b, :, :] = 0
    for n in range(state.end.shape[1]):
        state.end[b, n] = 0
        state.belief[b, n, :, :] = 0
        state.sensed[b, n, :, :] = False
        state.visited[b, n, :, :] = False
        state.journal[b, n, :] = 0
        state.history[b, n, :] = -1
        state.covered[b, n] = state.sensed_count[b, n] = state.known[b, n] = 0
        state.discovered[b, n] = state.received[b, n] = state.idle[b, n] = 0
        state.path_length[b, n] = state.collisions[b, n] = state.blocked[b, n] = state.sent_bytes[b, n] = 0
        state.reward[b, n] = 0.0
        state.outbox[b, n, :] = 0.0
        state.outbox_size[b, n] = -1
        state.read[b, n, :] = 0
        state.linked[b, n, :] = False
        state.heard_step[b, n, :] = -1
        state.heard_size[b, n, :] = -1
        state.heard_cell[b, n, :, :] = 0
        state.heard[b, n, :, :] = 0.0


@inner()
def _reach(state: State, ground: Ground, b: int) -> int:
    """Mark the cells that can be reached from the spawns in ``ground.part``; return how many they are."""
    ground.part[:] = 0
    reachable = 0
    for n in range(state.end.shape[1]):
        row, col = state.cell[b, n, 0], state.cell[b, n, 1]
        if ground.part[row, col] == 0:
            reachable += label_part(state.truth[b], row, col, 1, ground.part, ground.queue)
    return reachable


@inner()
def _count(rules: Rules, state: State, ground: Ground, b: int, reachable: int) -> None:
    """Fix what coverage counts, the goal and the budget, from the cells that can be reached."""
    height, width = ground.part.shape
    for row in range(height):
        for col in range(width):
            state.counts[b, row, col] = rules.counts_map or ground.part[row, col] > 0
    state.total[b] = height * width if rules.counts_map else reachable
    state.needed[b] = np.int64(np.ceil(rules.goal * state.total[b] - 1e-9))
    state.budget[b] = rules.budget if rules.budget > 0 else max(rules.least_budget, reachable)


@inner(inlined=False)
def _open(
    rules: Rules, state: State, optics: Optics, work: Work, ground: Ground, b: int, seed: int, reachable: int
) -> None:
    """Begin an episode; ``ground.part`` marks the cells that can be reached, so many."""
    _clear(state, b)
    _count(rules, state, ground, b, reachable)
    state.order_key[b] = stream_key(seed, ORDER, 0)
    state.radio_key[b] = stream_key(seed, RADIO, 0)
    begin(rules, state, optics, work, b)


@kernel()
def open_episode(engine: Engine, ground: Ground, b: int, seed: int) -> None:
    """Begin episode ``b`` on the true map and at the cells that the state holds."""
    reachable = _reach(engine.state, ground, b)
    _open(engine.rules, engine.state, engine.optics, engine.work, ground, b, seed, reachable)


@inner(inlined=False)
def _draw_attainable(rules: Rules, room: Room, truth: np.ndarray, ground: Ground, team: int, seed: int) -> int:
    """Draw the first room of a seed that will do and mark its main part; return that part's size, -1 for none."""
    for attempt in range(MAX_ATTEMPTS):
        draw_room(room, stream_key(seed, MAP, attempt), truth)
        size = mark_largest_part(truth, ground.part, ground.queue)
        if is_attainable(rules, truth, ground.part, size, team):
            return size
    return -1


@kernel()
def open_rooms(
    engine: Engine, room: Room, clustered: bool, ground: Ground, episodes: np.ndarray, seeds: np.ndarray
) -> int:
    """Begin episodes (K,) in the random rooms of seeds (K,).

    Returns how many were begun; fewer than K when no room of a seed will do.
    """
    rules, state, optics, work = engine.rules, engine.state, engine.optics, engine.work
    for k in range(episodes.shape[0]):
        b = episodes[k]
        size = _draw_attainable(rules, room, state.truth[b], ground, state.end.shape[1], seeds[k])
        if size < 0:
            return k
        place_team(stream_key(seeds[k], SPAWN, 0), clustered, -1, state.truth[b], ground, state.cell[b])
        _open(rules, state, optics, work, ground, b, seeds[k], size)  # all spawns are in the main part
    return len(episodes)
