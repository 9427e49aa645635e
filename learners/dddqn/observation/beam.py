"""A beam search for short tours that view all unknown cells of rooms of up to 16x16 cells, on bitboards.

A state is the UAV's cell and the set U of cells that are still unseen. Its rank, lower is better, is

    |U| (1 + isolation) - isolation / 4 * pairs(U) + pull * (steps since its last gain)

where pairs(U) counts the unordered pairs of neighbours, diagonal ones included, among the unseen cells U. So an
unseen cell weighs 1 + isolation (1 - n / 8) with n unseen cells around it: scattered leftovers are expensive, so the
UAV finishes a pocket while it is near. Each operation on a set takes some twenty word operations.

:mod:`indoor_explorers.planners.horizon.beam` searches maps of any size with cells of any weight. This search is
separate because it is many times faster and allocates nothing: a decision makes up to eight searches.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.compiled import inner, leaf
from indoor_explorers.env.grid.randomness import draw
from indoor_explorers.env.search.bitsets import (
    ROOM,
    STRIDE,
    Board,
    board_hash,
    board_size,
    is_new,
    neighbour_pairs,
    without,
)
from indoor_explorers.learners.dddqn.observation.memory import LONGEST

#: Search depth in steps.
DEPTH = LONGEST
#: Weight of a step without gain, and of each step for which a cell stays unseen.
PULL, DELAY = 0.02, 1e-4
#: The estimated steps of an unfinished tour are DEPTH + REST + PACE * rank.
PACE, REST = 0.1, 4.0
#: Columns of ``Beam.facts``: unseen cells, their pairs of neighbours, delay, rank, the step at which 90 % were seen (0
#: for not yet), steps since the last gain, and the index of the parent state.
LEFT, PAIRS, UNSEEN_STEPS, RANK, HALFWAY, IDLE, PARENT = range(7)
#: Columns of ``Beam.done``: delay, the step at which 90 % were seen, the last cell, and the index of the parent state.
DONE_DELAY, DONE_HALFWAY, DONE_CELL, DONE_PARENT = range(4)
_ONE = np.uint64(1)


class Beam(NamedTuple):
    """Working arrays: up to K states and as many candidates for the next step."""

    cell: np.ndarray
    """(2, K) cells; bank 0 holds the states, bank 1 the candidates."""
    unseen: np.ndarray
    """(2, K, 4) words of the sets of unseen cells."""
    key: np.ndarray
    """(2, K) hash of the unseen set."""
    facts: np.ndarray
    """(2, K, 7) numbers of each state: columns ``LEFT`` to ``PARENT``."""
    order: np.ndarray
    """(K,) candidates by rank."""
    met: np.ndarray
    """Hash table of the states met so far."""
    cell_key: np.ndarray
    """(256,) hash words of the UAV's cell."""
    trail: np.ndarray
    """(D + 1, K, 2) for every step, the cells of the kept states and the indices of their parents."""
    done: np.ndarray
    """(4,) the best finished tour: columns ``DONE_DELAY`` to ``DONE_PARENT``."""
    path: np.ndarray
    """(D + 1,) the cells of the latest tour, if it is finished."""


class Aim(NamedTuple):
    """The objective of a search."""

    rest: float
    """Unseen cells at which a tour is finished."""
    halfway: float
    """Unseen cells at 90 % coverage; the search notes the step at which a tour reaches it."""
    isolation: float
    """Additional weight of an unseen cell without unseen neighbours, in cells."""


class Tour(NamedTuple):
    """Result of a search."""

    finished: bool
    """Whether the tour leaves at most ``Aim.rest`` cells unseen."""
    steps: float
    """Its length in steps; an estimate if it is not finished."""
    delay: float
    """Number of unseen cells summed over its steps."""
    halfway: int
    """The step at which at most ``Aim.halfway`` cells were unseen, 0 if none."""


def new_beam(width: int) -> Beam:
    """Allocate the working arrays of a beam of ``width`` states."""
    table = 64
    while table < 4 * width * DEPTH:
        table *= 2
    return Beam(
        np.zeros((2, width), np.int64),
        np.zeros((2, width, 4), np.uint64),
        np.zeros((2, width), np.uint64),
        np.zeros((2, width, 7)),
        np.zeros(width, np.int64),
        np.zeros(table, np.uint64),
        np.array([draw(np.uint64(1), np.uint64(k)) for k in range(ROOM * STRIDE)], np.uint64),
        np.zeros((DEPTH + 1, width, 2), np.int64),
        np.zeros(4),
        np.zeros(DEPTH + 1, np.int64),
    )


@inner()
def _write(
    beam: Beam,
    bank: int,
    s: int,
    cell: int,
    words: Board,
    key: np.uint64,
    facts: tuple[float, float, float, float, float, float, float],
) -> None:
    beam.cell[bank, s], beam.key[bank, s] = cell, key
    unseen, numbers = beam.unseen[bank, s], beam.facts[bank, s]
    unseen[0], unseen[1], unseen[2], unseen[3] = words
    left, near, delay, rank, halfway, idle, parent = facts
    numbers[LEFT], numbers[PAIRS], numbers[UNSEEN_STEPS], numbers[RANK] = left, near, delay, rank
    numbers[HALFWAY], numbers[IDLE], numbers[PARENT] = halfway, idle, parent


@inner()
def _place(beam: Beam, kept: int, rank: float) -> tuple[int, int]:
    """Make room among the candidates, sorted by rank; return where to write (-1 for nowhere) and how many are kept."""
    width, ranks = beam.order.shape[0], beam.facts[1]
    if kept == width and rank >= ranks[beam.order[width - 1], RANK]:
        return -1, kept
    free = beam.order[width - 1] if kept == width else kept
    j = min(kept, width - 1)
    while j > 0 and ranks[beam.order[j - 1], RANK] > rank:
        beam.order[j] = beam.order[j - 1]
        j -= 1
    beam.order[j] = free
    return free, min(kept + 1, width)


@inner()
def _start(beam: Beam, cell: int, unseen: np.ndarray, views: np.ndarray, aim: Aim) -> float:
    """Write the initial state, the UAV in ``cell`` after an observation from there; return its unseen cells."""
    words = without(unseen, views[cell])
    left, near = float(board_size(words)), float(neighbour_pairs(words))
    rank = left * (1 + aim.isolation) - aim.isolation / 4 * near
    halfway = 1.0 if left <= aim.halfway else 0.0
    _write(beam, 0, 0, cell, words, board_hash(words), (left, near, left, rank, halfway, 0.0, 0.0))
    return left


@leaf(entry=False)
def _expand(beam: Beam, states: int, step: int, views: np.ndarray, passages: np.ndarray, aim: Aim) -> int:
    """Expand all states to ranked candidates and note the best finished one; return the number of candidates."""
    kept, share, done = 0, aim.isolation / 4, beam.done
    for s in range(states):
        parent = beam.facts[0, s]
        for k in range(4):
            cell = passages[beam.cell[0, s], k]
            if cell < 0:
                continue
            words = without(beam.unseen[0, s], views[cell])
            left = float(board_size(words))
            gains = left < parent[LEFT]
            key = board_hash(words) if gains else beam.key[0, s]
            if not is_new(beam.met, key ^ beam.cell_key[cell]):
                continue
            halfway = float(step) if parent[HALFWAY] == 0 and left <= aim.halfway else parent[HALFWAY]
            delay = parent[UNSEEN_STEPS] + left
            if left <= aim.rest:
                if delay < done[DONE_DELAY]:
                    done[DONE_DELAY], done[DONE_HALFWAY], done[DONE_CELL], done[DONE_PARENT] = delay, halfway, cell, s
                continue
            near = float(neighbour_pairs(words)) if gains else parent[PAIRS]
            idle = 0.0 if gains else parent[IDLE] + 1
            rank = left * (1 + aim.isolation) - share * near + PULL * idle + DELAY * delay
            at, kept = _place(beam, kept, rank)
            if at >= 0:
                _write(beam, 1, at, cell, words, key, (left, near, delay, rank, halfway, idle, float(s)))
    return kept


@inner()
def _advance(beam: Beam, kept: int, step: int) -> None:
    """Copy the candidates to the states of ``step``, best first."""
    for s in range(kept):
        o = beam.order[s]
        beam.cell[0, s], beam.key[0, s] = beam.cell[1, o], beam.key[1, o]
        for k in range(4):
            beam.unseen[0, s, k] = beam.unseen[1, o, k]
        for k in range(7):
            beam.facts[0, s, k] = beam.facts[1, o, k]
        beam.trail[step, s, 0], beam.trail[step, s, 1] = beam.cell[1, o], int(beam.facts[1, o, PARENT])


@inner()
def _trace(beam: Beam, steps: int) -> None:
    """Write the cells of the finished tour."""
    beam.path[steps - 1] = int(beam.done[DONE_CELL])
    state = int(beam.done[DONE_PARENT])
    for step in range(steps - 1, 0, -1):
        beam.path[step - 1] = beam.trail[step, state, 0]
        state = beam.trail[step, state, 1]


@leaf()
def shortest_tour(cell: int, unseen: np.ndarray, views: np.ndarray, passages: np.ndarray, aim: Aim, beam: Beam) -> Tour:
    """Search for a short tour that begins with a step to ``cell`` and leaves at most ``aim.rest`` of ``unseen`` (4,).

    ``views`` and ``passages`` are those of
    :class:`indoor_explorers.learners.dddqn.observation.memory.ObservationMemory`. Among found tours of equal length the
    one with the least delay is returned; ``beam.path`` gets its cells.
    """
    left = _start(beam, cell, unseen, views, aim)
    beam.trail[1, 0, 0], beam.path[0] = cell, cell
    if left <= aim.rest:
        return Tour(True, 1.0, left, 1)
    beam.met[:] = 0
    states = 1
    for step in range(2, DEPTH + 1):
        beam.done[DONE_DELAY] = np.inf
        kept = _expand(beam, states, step, views, passages, aim)
        if beam.done[DONE_DELAY] < np.inf:
            _trace(beam, step)
            return Tour(True, float(step), beam.done[DONE_DELAY], int(beam.done[DONE_HALFWAY]))
        if kept == 0:
            break
        _advance(beam, kept, step)
        states = kept
    best = beam.facts[0, 0]
    return Tour(False, DEPTH + REST + PACE * best[RANK], best[UNSEEN_STEPS], int(best[HALFWAY]))


@leaf()
def follow_tour(
    at: int, path: np.ndarray, unseen: np.ndarray, views: np.ndarray, passages: np.ndarray, aim: Aim
) -> Tour:
    """Evaluate an earlier tour for a UAV in cell ``at``; the result is not finished if the tour cannot be flown.

    ``path`` (L,) holds its cells from the next one on, -1 after the last. ``unseen`` (4,) uint64 is the bit set of the
    cells to view, ``views`` (R, 4) uint64 and ``passages`` (R, 4) are those of the memory.
    """
    a, b, c, d = unseen[0], unseen[1], unseen[2], unseen[3]
    delay, halfway = 0.0, 0
    for k in range(path.shape[0]):
        cell = path[k]
        if cell < 0 or not _joined(passages[at], cell):
            break
        at = cell
        a, b, c, d = a & ~views[at, 0], b & ~views[at, 1], c & ~views[at, 2], d & ~views[at, 3]
        left = float(board_size((a, b, c, d)))
        delay += left
        if halfway == 0 and left <= aim.halfway:
            halfway = k + 1
        if left <= aim.rest:
            return Tour(True, k + 1.0, delay, halfway)
    return Tour(False, np.inf, np.inf, 0)


@inner()
def _joined(neighbours: np.ndarray, cell: int) -> bool:
    return bool(neighbours[0] == cell or neighbours[1] == cell or neighbours[2] == cell or neighbours[3] == cell)
