"""Planner features of the moves in small rooms: what tours a small beam search finds behind each of them.

Unknown cells are taken to be free to fly through and transparent but for those that the learned map prior is nearly
certain about (:mod:`~indoor_explorers.learners.dddqn.observation.optimistic_map`). Cells that it rather takes for
obstacles need not be seen while others are left. Cells that a teammate was nearer to when it was last heard are left to
it while others are left; those that are as near to both are the lower number's. So are those in the sector of a
teammate never heard, where it was not likely to be heard.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import FREE, MOVES, UNKNOWN
from indoor_explorers.env.grid.compiled import inner, leaf
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.search.bitsets import ROOM, STRIDE, WORDS, board_size, remove
from indoor_explorers.env.search.optimistic_views import attainable
from indoor_explorers.learners.dddqn.observation.beam import Aim, Beam, Tour, follow_tour, new_beam, shortest_tour
from indoor_explorers.learners.dddqn.observation.layout import BEYOND
from indoor_explorers.learners.dddqn.observation.memory import LONGEST


class Planner(NamedTuple):
    """Scratch of the search for tours."""

    beam: Beam
    attainable: np.ndarray
    """(4,) words: what can be seen from anywhere in reach."""
    unseen: np.ndarray
    """(4,) words: what of it tours are to see."""
    steps: np.ndarray
    """(256,) distances of a flood."""
    queue: np.ndarray
    """(256,)."""
    stale: np.ndarray
    """(16, 16) cells whose views have changed."""
    found: np.ndarray
    """(4, 2, 4) the tours behind each move, to the goal and to the mark."""
    paths: np.ndarray
    """(4, 2, 41) their cells, -1 after the last and where a tour is not finished."""
    least: np.ndarray
    """(3,)."""
    sector: np.ndarray
    """(H, W) the UAV in whose sector of the map a cell lies, -1 where there are none; empty where tours are not."""


def new_planner(shape: tuple[int, int], scenario: Scenario, width: int) -> Planner:
    """Allocate the scratch for maps of (H, W) cells and a search that keeps ``width`` states at each step."""
    return Planner(
        beam=new_beam(width),
        attainable=np.zeros(WORDS, np.uint64),
        unseen=np.zeros(WORDS, np.uint64),
        steps=np.zeros(ROOM * STRIDE, np.int32),
        queue=np.zeros(ROOM * STRIDE, np.int32),
        stale=np.zeros((ROOM, STRIDE), np.uint8),
        found=np.zeros((4, 2, 4)),
        paths=np.zeros((4, 2, LONGEST + 1), np.int64),
        least=np.zeros(3),
        sector=sectors(shape, scenario) if max(shape) <= ROOM else np.empty((0, 0), np.int64),
    )


def sectors(shape: tuple[int, int], scenario: Scenario) -> NDArray[np.int64]:
    """Return (H, W) which of the team's equally large sectors around the middle of the map each cell lies in.

    There are none, -1, where some teammate is likely to be in radio range from the beginning.
    """
    team, radio = scenario.team, scenario.radio
    reach = {"none": 0.0, "unlimited": np.inf}.get(radio.model, radio.range)
    if (team - 1) * (2.0 * reach + 1.0) ** 2 > OFTEN * shape[0] * shape[1]:
        return np.full(shape, -1)
    rows, cols = np.mgrid[: shape[0], : shape[1]]
    bearing = np.arctan2(2 * rows + 1 - shape[0], 2 * cols + 1 - shape[1])
    rank = np.argsort(np.argsort(bearing, axis=None, kind="stable"), kind="stable")
    return np.asarray((rank * team // bearing.size).reshape(shape), np.int64)


#: Shares of the cells that tours leave unseen: at the goal, and at the mark on the way.
GOAL_REST, HALFWAY_REST = 0.01, 0.1
#: Part of a cell that may be missing at the goal, as all shares are estimates.
SLACK = 0.2
#: Extra weight of isolated unseen cells in tours to the goal: in a room without obstacles so far, and with some.
OPEN_ISOLATION, ISOLATION = 8.0, 20.0
#: The same for tours to the mark on the way, as a factor.
HALFWAY_ISOLATION = 0.25
#: Chances below this, of 255, let a cell be left out.
LIKELY = 96
#: Share of the map that teammates' radios cover together above which they are likely to be heard from the beginning.
OFTEN = 0.4
#: Scales of the features: steps, steps to the mark, delay beyond the least.
STEPS, HALFWAY_STEPS, DELAYS = 48.0, 40.0, 200.0


@inner()
def _is_a_mates(
    row: int, col: int, agent: int, r: int, c: int, mates: np.ndarray, ages: np.ndarray, sector: np.ndarray
) -> bool:
    """Tell whether (r, c) is a teammate's: one that was nearer when last heard, or one never heard in its sector."""
    owner = sector[r, c]
    if owner >= 0 and owner != agent and ages[owner] < 0:
        return True
    own = abs(row - r) + abs(col - c)
    for m in range(ages.shape[0]):
        if ages[m] >= 0 and abs(mates[m, 0] - r) + abs(mates[m, 1] - c) < own + (m < agent):
            return True
    return False


@inner(inlined=False)
def _wanted(
    belief: np.ndarray,
    cell: np.ndarray,
    agent: int,
    mates: np.ndarray,
    ages: np.ndarray,
    chance: np.ndarray,
    sector: np.ndarray,
    out: np.ndarray,
    stage: int,
) -> int:
    """Take from ``out`` (4,) what is known, from stage 1 on what is unlikely, at 2 what is a mate's; count the rest."""
    for r in range(belief.shape[0]):
        for c in range(belief.shape[1]):
            left_out = belief[r, c] != UNKNOWN or (stage > 0 and chance[r, c] < LIKELY)
            if left_out or (stage > 1 and _is_a_mates(cell[0], cell[1], agent, r, c, mates, ages, sector)):
                remove(out, r * STRIDE + c)
    return board_size((out[0], out[1], out[2], out[3]))


@inner()
def _free(belief: np.ndarray) -> int:
    total = 0
    for r in range(belief.shape[0]):
        for c in range(belief.shape[1]):
            total += belief[r, c] == FREE
    return total


@inner(inlined=False)
def _choose_unseen(
    belief: np.ndarray,
    cell: np.ndarray,
    agent: int,
    mates: np.ndarray,
    ages: np.ndarray,
    chance: np.ndarray,
    planner: Planner,
) -> tuple[int, float]:
    """Write what tours are to see (4,); return how much that is and how many cells there may be to count in all."""
    left, total, free, unseen = 0, 0.0, _free(belief), planner.unseen
    for stage in (2, 1, 0):
        for w in range(WORDS):
            unseen[w] = planner.attainable[w]
        left = _wanted(belief, cell, agent, mates, ages, chance, planner.sector, unseen, stage)
        total = float(free + left)
        if left > GOAL_REST * total + SLACK:
            break
    return left, total


@inner(inlined=False)
def _search(
    at: int, move: int, kind: int, views: np.ndarray, passages: np.ndarray, planner: Planner, aim: Aim, kept: np.ndarray
) -> None:
    """Find a tour behind a move; the ``kept`` one (41,), found before, is taken where it is better."""
    after = at + MOVES[move, 0] * STRIDE + MOVES[move, 1]
    path, facts = planner.paths[move, kind], planner.found[move, kind]
    tour = shortest_tour(after, planner.unseen, views, passages, aim, planner.beam)
    for k in range(path.shape[0]):
        path[k] = planner.beam.path[k] if tour.finished and k < tour.steps else -1
    if kept[0] == after:
        old = follow_tour(at, kept, planner.unseen, views, passages, aim)
        if old.steps < tour.steps or (old.steps == tour.steps and old.delay < tour.delay):
            tour = old
            for k in range(path.shape[0]):
                path[k] = kept[k] if k < old.steps else -1
    facts[0], facts[1], facts[2], facts[3] = tour.finished, tour.steps, tour.delay, tour.halfway


@inner()
def _move_on(at: int, kept: np.ndarray) -> None:
    """Take the first cell off a tour when the UAV is there."""
    if kept[0] == at:
        for k in range(kept.shape[0] - 1):
            kept[k] = kept[k + 1]


@inner()
def _keep_best(kind: int, planner: Planner, blocked: np.ndarray, kept: np.ndarray) -> None:
    """Remember the best tour of all moves."""
    best = -1
    for k in range(4):
        if blocked[k] == 0 and planner.paths[k, kind, 0] >= 0:
            mine, its = planner.found[k, kind], planner.found[best, kind]
            if best < 0 or mine[1] < its[1] or (mine[1] == its[1] and mine[2] < its[2]):
                best = k
    for k in range(kept.shape[0]):
        kept[k] = planner.paths[best, kind, k] if best >= 0 else -1


@inner()
def _kept(numbers: np.ndarray) -> Tour:
    return Tour(numbers[0] > 0, numbers[1], numbers[2], int(numbers[3]))


@inner()
def _write(goal: Tour, mark: Tour, least: np.ndarray, left: int, total: float, early: bool, out: np.ndarray) -> None:
    """Write the twelve features of one move; ``least`` holds the least steps, delay and steps to the mark of all."""
    out[0] = goal.finished
    out[1] = min((goal.steps - least[0]) / BEYOND, 1.0)
    out[2] = goal.steps == least[0]
    out[3] = min(goal.steps / STEPS, 2.0)
    out[4] = min((goal.delay - least[1]) / DELAYS, 1.0)
    out[5] = goal.delay / (max(left, 1) * goal.steps)
    out[6] = left / total
    if early:
        out[7] = mark.finished
        out[8] = min((mark.steps - least[2]) / BEYOND, 1.0)
        out[9] = mark.steps == least[2]
        out[10] = min(mark.steps / HALFWAY_STEPS, 2.0)
        out[11] = min(max((goal.halfway - least[2]) / BEYOND, 0.0), 1.0)


@leaf()
def look_for_tours(
    belief: np.ndarray,
    cell: np.ndarray,
    agent: int,
    mates: np.ndarray,
    ages: np.ndarray,
    chance: np.ndarray,
    views: np.ndarray,
    passages: np.ndarray,
    kept: np.ndarray,
    planner: Planner,
    obstructed: bool,
    blocked: np.ndarray,
    out: np.ndarray,
) -> None:
    """Write the features of the four moves into ``out`` (4, 12); those of ``blocked`` (4,) moves say so.

    ``cell`` (2,) is where UAV ``agent`` is, ``mates`` (M, 2) and ``ages`` (M,) where and how many steps ago others were
    heard, -1 for never. ``kept`` (2, 41) are the best tours found before, to the goal and to the mark, and are brought
    up to date.
    """
    at = cell[0] * STRIDE + cell[1]
    attainable(at, views, passages, planner.queue, planner.steps, planner.attainable)
    left, total = _choose_unseen(belief, cell, agent, mates, ages, chance, planner)
    rest, halfway = GOAL_REST * total + SLACK, HALFWAY_REST * total
    early, isolation = left > halfway, ISOLATION if obstructed else OPEN_ISOLATION
    goal_aim = Aim(rest if left > rest else 0.0, halfway, isolation)
    mark_aim = Aim(halfway, halfway, isolation * HALFWAY_ISOLATION)
    found, least = planner.found, planner.least
    least[:] = np.inf
    _move_on(at, kept[0])
    _move_on(at, kept[1])
    for k in range(4):
        if blocked[k] == 0:
            _search(at, k, 0, views, passages, planner, goal_aim, kept[0])
            if early:
                _search(at, k, 1, views, passages, planner, mark_aim, kept[1])
            least[0], least[1] = min(least[0], found[k, 0, 1]), min(least[1], found[k, 0, 2])
            least[2] = min(least[2], found[k, 1, 1])
    _keep_best(0, planner, blocked, kept[0])
    if early:
        _keep_best(1, planner, blocked, kept[1])
    for k in range(4):
        out[k] = 0.0
        out[k, 1] = out[k, 8] = float(blocked[k])
        if blocked[k] == 0:
            _write(_kept(found[k, 0]), _kept(found[k, 1]), least, left, total, early, out[k])
