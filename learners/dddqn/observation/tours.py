"""Tour features of the moves in small rooms: the tours that begin with each move, found by a beam search.

The search plans on the optimistic map (:mod:`~indoor_explorers.learners.dddqn.observation.map_prior`). Its tours
need not view cells that are probably obstacles by the map prior, as long as other cells are left. Likewise they leave a
cell to a teammate that was closer to it when last heard (at equal distance to the lower number), or that got it in a
division (:mod:`~indoor_explorers.learners.dddqn.observation.division`), and a cell in the sector of a teammate that was
never heard, in scenarios whose radio seldom connects the team at the start.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import FREE, MOVES, UNKNOWN
from indoor_explorers.env.grid.compiled import inner, leaf
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.search.bitsets import ROOM, STRIDE, WORDS, board_size, holds, remove
from indoor_explorers.learners.dddqn.observation.beam import Aim, Beam, Tour, follow_tour, new_beam, shortest_tour
from indoor_explorers.learners.dddqn.observation.division import DivisionScratch, divide, new_division
from indoor_explorers.learners.dddqn.observation.layout import BEYOND, DELAYS, TOURS
from indoor_explorers.learners.dddqn.observation.memory import LONGEST
from indoor_explorers.learners.dddqn.observation.uav import Uav
from indoor_explorers.planners.toolbox.information.optimistic_views import attainable

#: Shares of the cells that tours leave unseen: at the goal (99 %) and at the mark (90 %).
GOAL_REST, HALFWAY_REST = 0.01, 0.1
#: Cells that may be missing at the goal in addition, since the total is an estimate.
SLACK = 0.2
#: Additional weight of isolated unseen cells in tours to the goal: without known obstacles, and with some.
OPEN_ISOLATION, ISOLATION = 8.0, 20.0
#: Factor on this weight in tours to the mark.
HALFWAY_ISOLATION = 0.25
#: Probability by the map prior, times 255, below which a cell may be left out.
LIKELY = 96
#: Share of the map covered by the radios of all teammates above which teammates are likely to hear each other at the
#: start.
OFTEN = 0.4
#: Scales of the features: steps, steps to the mark.
STEPS, HALFWAY_STEPS = 48.0, 40.0
#: Columns of ``TourScratch.found``.
_FINISHED, _STEPS, _DELAY, _HALFWAY = range(4)
#: Columns of ``TourScratch.least``: the least steps, delay and steps to the mark of all moves.
_LEAST_STEPS, _LEAST_DELAY, _LEAST_TO_MARK = range(3)
#: Kinds of tours: to the goal, and to the mark of 90 %.
_GOAL, _MARK = range(2)
#: Columns of the features of a move, in the order of ``TOURS``.
_GOAL_FOUND, _GOAL_BEYOND, _GOAL_SHORTEST, _GOAL_STEPS, _DELAY_BEYOND, _MEAN_UNSEEN = range(6)
_UNKNOWN_SHARE, _MARK_FOUND, _MARK_BEYOND, _MARK_SHORTEST, _MARK_STEPS, _GOAL_HALFWAY = range(6, len(TOURS))


class TourScratch(NamedTuple):
    """Working arrays of the search for tours."""

    beam: Beam
    """The working arrays of the beam search."""
    attainable: np.ndarray
    """(4,) words: cells that can be viewed from any reachable cell."""
    unseen: np.ndarray
    """(4,) words: the attainable cells that tours have to view."""
    steps: np.ndarray
    """(256,) distances of a breadth-first search."""
    queue: np.ndarray
    """(256,) its queue."""
    stale: np.ndarray
    """(16, 16) cells whose views have changed."""
    found: np.ndarray
    """(4, 2, 4) the tours that begin with each move, to the goal and to the mark."""
    paths: np.ndarray
    """(4, 2, 41) their cells, -1 after the last; only -1 for an unfinished tour."""
    least: np.ndarray
    """(3,) the minima over all moves."""
    sector: np.ndarray
    """(H, W) number of the UAV in whose sector a cell lies, -1 without sectors; empty on larger maps."""
    division: DivisionScratch
    """The working arrays of the division among teammates."""


def new_tour_scratch(shape: tuple[int, int], scenario: Scenario, width: int, *, division: bool) -> TourScratch:
    """Allocate the working arrays for maps of (H, W) cells and a beam of ``width`` states; ``division`` among mates."""
    return TourScratch(
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
        division=new_division(scenario.team * division),
    )


def sectors(shape: tuple[int, int], scenario: Scenario) -> NDArray[np.int64]:
    """Divide the map into one sector of equal area around its middle for each UAV; return each cell's sector (H, W).

    All are -1, for no sectors, if some teammate is likely to be in radio range at the start.
    """
    team, radio = scenario.team, scenario.radio
    reach = {"none": 0.0, "unlimited": np.inf}.get(radio.model, radio.range)
    if (team - 1) * (2.0 * reach + 1.0) ** 2 > OFTEN * shape[0] * shape[1]:
        return np.full(shape, -1)
    rows, cols = np.mgrid[: shape[0], : shape[1]]
    bearing = np.arctan2(2 * rows + 1 - shape[0], 2 * cols + 1 - shape[1])
    rank = np.argsort(np.argsort(bearing, axis=None, kind="stable"), kind="stable")
    return np.asarray((rank * team // bearing.size).reshape(shape), np.int64)


@inner()
def _rest(total: float) -> float:
    """Return the number of cells that tours to the goal may leave unseen, of so many free cells."""
    return GOAL_REST * total + SLACK


@inner()
def _is_a_mates(uav: Uav, r: int, c: int, scratch: TourScratch) -> bool:
    """Tell whether (r, c) is left to a teammate: one that got it or was closer, or one never heard, in its sector."""
    owner, agent, ages, mates = scratch.sector[r, c], uav.agent, uav.ages, uav.mates
    if owner >= 0 and owner != agent and ages[owner] < 0:
        return True
    if scratch.division.first.shape[0] > 0:
        return holds(scratch.division.left, r * STRIDE + c)
    own = abs(uav.row - r) + abs(uav.col - c)
    for m in range(ages.shape[0]):
        if ages[m] >= 0 and abs(mates[m, 0] - r) + abs(mates[m, 1] - c) < own + (m < agent):
            return True
    return False


@leaf(entry=False)
def _write_unseen(uav: Uav, scratch: TourScratch, stage: int) -> int:
    """Write the cells that tours have to view at a stage and return their number.

    Without known cells; from stage 1 on also without unlikely ones; at stage 2 also without those left to teammates.
    """
    belief, chance, out = uav.belief, uav.chance, scratch.unseen
    for w in range(WORDS):
        out[w] = scratch.attainable[w]
    for r in range(belief.shape[0]):
        for c in range(belief.shape[1]):
            left_out = belief[r, c] != UNKNOWN or (stage > 0 and chance[r, c] < LIKELY)
            if left_out or (stage > 1 and _is_a_mates(uav, r, c, scratch)):
                remove(out, r * STRIDE + c)
    return board_size((out[0], out[1], out[2], out[3]))


@inner()
def _free(belief: np.ndarray) -> int:
    total = 0
    for r in range(belief.shape[0]):
        for c in range(belief.shape[1]):
            total += belief[r, c] == FREE
    return total


@leaf(entry=False)
def _divided(uav: Uav, scratch: TourScratch, isolation: float) -> tuple[float, float]:
    """Divide the unseen cells; return the estimated number of free cells in all, and the own share of the rest.

    The number is 0 where no teammate was heard.
    """
    total = float(_free(uav.belief) + _write_unseen(uav, scratch, 1))
    aim = Aim(_rest(total), 0.0, isolation)
    share = divide(uav, scratch.division, scratch.unseen, aim, scratch.queue, scratch.steps)
    return total if share < 1.0 else 0.0, share


@leaf(entry=False)
def _choose_unseen(uav: Uav, scratch: TourScratch, isolation: float) -> tuple[int, float, float]:
    """Write the cells that tours have to view.

    Returns their number, the estimated number of free cells in all, and the UAV's share of the cells that may stay
    unseen: below 1 in its own part of a division.
    """
    everything, share = _divided(uav, scratch, isolation) if scratch.division.first.shape[0] > 0 else (0.0, 1.0)
    left, total, free = 0, 0.0, _free(uav.belief)
    for stage in (2, 1, 0):
        left = _write_unseen(uav, scratch, stage)
        total, share = max(float(free + left), everything), share if stage == 2 else 1.0
        if left > _rest(total) * share:
            break
    return left, total, share


@leaf(entry=False)
def _search(
    at: int,
    move: int,
    kind: int,
    views: np.ndarray,
    passages: np.ndarray,
    scratch: TourScratch,
    aim: Aim,
    kept: np.ndarray,
) -> None:
    """Find a tour that begins with a move; use the ``kept`` one (41,) of an earlier step if it is better."""
    after = at + MOVES[move, 0] * STRIDE + MOVES[move, 1]
    path, found = scratch.paths[move, kind], scratch.found[move, kind]
    tour = shortest_tour(after, scratch.unseen, views, passages, aim, scratch.beam)
    for k in range(path.shape[0]):
        path[k] = scratch.beam.path[k] if tour.finished and k < tour.steps else -1
    if kept[0] == after:
        old = follow_tour(at, kept, scratch.unseen, views, passages, aim)
        if old.steps < tour.steps or (old.steps == tour.steps and old.delay < tour.delay):
            tour = old
            for k in range(path.shape[0]):
                path[k] = kept[k] if k < old.steps else -1
    found[_FINISHED], found[_STEPS] = tour.finished, tour.steps
    found[_DELAY], found[_HALFWAY] = tour.delay, tour.halfway


@inner()
def _move_on(at: int, kept: np.ndarray) -> None:
    """Remove the first cell of a tour if the UAV has reached it."""
    if kept[0] == at:
        for k in range(kept.shape[0] - 1):
            kept[k] = kept[k + 1]


@inner()
def _keep_best(kind: int, scratch: TourScratch, blocked: np.ndarray, kept: np.ndarray) -> None:
    """Keep the best tour of all moves for the next step."""
    best = -1
    for k in range(4):
        if blocked[k] == 0 and scratch.paths[k, kind, 0] >= 0:
            mine, its = scratch.found[k, kind], scratch.found[best, kind]
            if best < 0 or mine[_STEPS] < its[_STEPS] or (mine[_STEPS] == its[_STEPS] and mine[_DELAY] < its[_DELAY]):
                best = k
    for k in range(kept.shape[0]):
        kept[k] = scratch.paths[best, kind, k] if best >= 0 else -1


@inner()
def _kept(numbers: np.ndarray) -> Tour:
    return Tour(numbers[_FINISHED] > 0, numbers[_STEPS], numbers[_DELAY], int(numbers[_HALFWAY]))


@inner()
def _write(goal: Tour, mark: Tour, least: np.ndarray, left: int, total: float, early: bool, out: np.ndarray) -> None:
    """Write the twelve features of one move; ``least`` holds the minima of steps, delay and steps to the mark."""
    out[_GOAL_FOUND] = goal.finished
    out[_GOAL_BEYOND] = min((goal.steps - least[_LEAST_STEPS]) / BEYOND, 1.0)
    out[_GOAL_SHORTEST] = goal.steps == least[_LEAST_STEPS]
    out[_GOAL_STEPS] = min(goal.steps / STEPS, 2.0)
    out[_DELAY_BEYOND] = min((goal.delay - least[_LEAST_DELAY]) / DELAYS, 1.0)
    out[_MEAN_UNSEEN] = goal.delay / (max(left, 1) * goal.steps)
    out[_UNKNOWN_SHARE] = left / total
    if early:
        out[_MARK_FOUND] = mark.finished
        out[_MARK_BEYOND] = min((mark.steps - least[_LEAST_TO_MARK]) / BEYOND, 1.0)
        out[_MARK_SHORTEST] = mark.steps == least[_LEAST_TO_MARK]
        out[_MARK_STEPS] = min(mark.steps / HALFWAY_STEPS, 2.0)
        out[_GOAL_HALFWAY] = min(max((goal.halfway - least[_LEAST_TO_MARK]) / BEYOND, 0.0), 1.0)


@leaf(entry=False)
def write_tours(uav: Uav, scratch: TourScratch, obstructed: bool, blocked: np.ndarray, out: np.ndarray) -> None:
    """Write the tour features of a UAV's four moves into ``out`` (4, 12).

    A ``blocked`` (4,) move has zeros, except that its steps beyond the shortest tours are 1. ``uav.views`` and
    ``uav.passages`` must be up to date. ``uav.tour``, the best tours so far, is updated.
    """
    views, passages, kept = uav.views, uav.passages, uav.tour
    at = uav.row * STRIDE + uav.col
    attainable(at, views, passages, scratch.queue, scratch.steps, scratch.attainable)
    isolation = ISOLATION if obstructed else OPEN_ISOLATION
    left, total, share = _choose_unseen(uav, scratch, isolation)
    rest, halfway = _rest(total) * share, HALFWAY_REST * total * share
    early = left > halfway
    goal_aim = Aim(rest if left > rest else 0.0, halfway, isolation)
    mark_aim = Aim(halfway, halfway, isolation * HALFWAY_ISOLATION)
    found, least = scratch.found, scratch.least
    least[:] = np.inf
    _move_on(at, kept[_GOAL])
    _move_on(at, kept[_MARK])
    for k in range(4):
        if blocked[k] == 0:
            _search(at, k, _GOAL, views, passages, scratch, goal_aim, kept[_GOAL])
            if early:
                _search(at, k, _MARK, views, passages, scratch, mark_aim, kept[_MARK])
            least[_LEAST_STEPS] = min(least[_LEAST_STEPS], found[k, _GOAL, _STEPS])
            least[_LEAST_DELAY] = min(least[_LEAST_DELAY], found[k, _GOAL, _DELAY])
            least[_LEAST_TO_MARK] = min(least[_LEAST_TO_MARK], found[k, _MARK, _STEPS])
    _keep_best(_GOAL, scratch, blocked, kept[_GOAL])
    if early:
        _keep_best(_MARK, scratch, blocked, kept[_MARK])
    for k in range(4):
        out[k] = 0.0
        out[k, _GOAL_BEYOND] = out[k, _MARK_BEYOND] = float(blocked[k])
        if blocked[k] == 0:
            _write(_kept(found[k, _GOAL]), _kept(found[k, _MARK]), least, left, total, early, out[k])
