"""Moves that explore steadily; they are recorded before a world is timed and replayed while it is timed.

Random walks often return to cells, which are then not scanned again; a UAV that explores scans at nearly every step.
These moves are the harder load: every UAV flies to the nearest cell that no UAV of its team has visited, straight on
where there is a choice. They use the true map, so they are not a policy.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import Scenario, World
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.grid.levels import Levels, beside, degree
from indoor_explorers.env.simulation.state import State
from indoor_explorers.evaluation.studies.bench.worlds import first_episodes, next_episodes

#: Turns in the order of preference: straight on, right, left, back; moves are numbered clockwise.
TURNS = np.array([0, 1, 3, 2])


class SearchArrays(NamedTuple):
    """Working arrays of a search."""

    seen: NDArray[np.int64]
    """(H*W,) the last search that reached the cell."""
    way: NDArray[np.int64]
    """(H*W,) the first move of the path there."""
    queue: NDArray[np.int64]
    """(H*W,) cells reached, in order of distance."""


@leaf(entry=False)
def _is_mate(state: State, b: int, row: int, col: int) -> bool:
    for mate in range(state.end.shape[1]):
        if state.end[b, mate] == 0 and state.cell[b, mate, 0] == row and state.cell[b, mate, 1] == col:
            return True
    return False


@leaf(entry=False)
def _is_new(state: State, b: int, row: int, col: int) -> bool:
    visits = 0
    for n in range(state.end.shape[1]):
        visits += state.visited[b, n, row, col]
    return visits == 0


@leaf(entry=False)
def _move_of(state: State, b: int, agent: int, heading: int, arrays: SearchArrays, search: int, rise: int) -> int:
    """Return the first move to the nearest new cell, 4 if there is none or teammates block the way."""
    height, width = state.truth.shape[1], state.truth.shape[2]
    origin = state.cell[b, agent, 0] * width + state.cell[b, agent, 1]
    arrays.queue[0], arrays.seen[origin] = origin, search
    head, tail = 0, 1
    while head < tail:
        row, col = divmod(arrays.queue[head], width)
        for k in range(degree(rise)):
            turn = (heading + TURNS[k]) % 4 if k < 4 else k
            r, c = beside(row, col, turn, rise)
            cell = r * width + c
            if not (0 <= r < height and 0 <= c < width) or state.truth[b, r, c] != FREE or arrays.seen[cell] == search:
                continue
            if head == 0 and _is_mate(state, b, r, c):
                continue
            arrays.seen[cell], arrays.queue[tail] = search, cell
            arrays.way[cell] = turn + (turn > 3) if head == 0 else arrays.way[arrays.queue[head]]
            tail += 1
            if _is_new(state, b, r, c):
                return int(arrays.way[cell])
        head += 1
    return 4


@kernel()
def _choose(
    state: State, headings: np.ndarray, arrays: SearchArrays, searches: int, actions: np.ndarray, rise: int
) -> int:
    """Fill ``actions`` (B, N) and update ``headings`` (B, N); return the total number of searches."""
    for b in range(state.end.shape[0]):
        for n in range(state.end.shape[1]):
            searches += 1
            actions[b, n] = _move_of(state, b, n, headings[b, n], arrays, searches, rise)
            if actions[b, n] < 4:
                headings[b, n] = actions[b, n]
    return searches


def exploring_moves(task: Scenario, batch: int, steps: int) -> NDArray[np.int64]:
    """Return (steps, B, N) moves for the episodes that ``world_speed`` flies."""
    world = World(task, batch)
    seeds = first_episodes(world)
    cells = world.state.truth[0].size
    arrays = SearchArrays(*(np.zeros(cells, np.int64) for _ in SearchArrays._fields))
    moves = np.empty((steps, batch, task.team), np.int64)
    rise = Levels.of(world.state.truth.shape[1:], task.map.level_count).rise
    headings, searches = np.zeros((batch, task.team), np.int64), 0
    for actions in moves:
        searches = _choose(world.state, headings, arrays, searches, actions, rise)
        world.step(actions)
        next_episodes(world, seeds)
    return moves
