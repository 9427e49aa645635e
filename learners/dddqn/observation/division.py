"""Division of the unseen cells among teammates in small rooms, so that their tours take about equally long.

A cell goes to the linked UAV that can view it first, counted from a start that is delayed where the UAV's tour is long:
an additively weighted Voronoi partition (Okabe et al., Spatial Tessellations, 2nd ed. 2000, chapter 3) whose
weights are adapted to the lengths of the tours that a beam search finds; the longest tour decides when the team has
finished (min-max, Arkin, Hassin and Levin 2006, doi:10.1016/j.jalgor.2005.01.007). Linked UAVs share their maps and
positions, so each finds the same division by itself. What a teammate was given is left to it, after contact is lost as
well, until the own part is finished.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.grid.compiled import inner, leaf
from indoor_explorers.env.search.bfs import flood_table
from indoor_explorers.env.search.bitsets import ROOM, STRIDE, WORDS, holds, insert, lowest
from indoor_explorers.learners.dddqn.observation.beam import Aim, Beam, new_beam, shortest_tour
from indoor_explorers.learners.dddqn.observation.uav import Uav

#: Number of corrections of the delays, and the correction for each step by which a tour is longer than the mean.
ROUNDS, CORRECTION = 6, 0.25
#: Width of the beam that finds the tours of all UAVs.
WIDTH = 8
#: Steps to a cell that cannot be viewed.
NEVER = 1000
_ONE = np.uint64(1)


class DivisionScratch(NamedTuple):
    """Working arrays for teams of M UAVs; M is 0 if nothing is divided."""

    first: np.ndarray
    """(M, 256) steps after which each linked UAV can view a cell."""
    delay: np.ndarray
    """(M,) delay of each UAV's start in steps."""
    best: np.ndarray
    """(M,) the delays of the best division so far."""
    length: np.ndarray
    """(M,) steps of each UAV's tour."""
    owner: np.ndarray
    """(256,) number of the UAV that gets a cell, -1 for none."""
    part: np.ndarray
    """(4,) words: the cells of one UAV."""
    left: np.ndarray
    """(4,) words: the cells that are left to teammates."""
    beam: Beam
    """The working arrays of the beam search."""


def new_division(team: int) -> DivisionScratch:
    """Allocate the working arrays for a team, of 0 UAVs if nothing is divided."""
    return DivisionScratch(
        first=np.zeros((team, ROOM * STRIDE), np.int32),
        delay=np.zeros(team),
        best=np.zeros(team),
        length=np.zeros(team),
        owner=np.zeros(ROOM * STRIDE, np.int64),
        part=np.zeros(WORDS, np.uint64),
        left=np.zeros(WORDS, np.uint64),
        beam=new_beam(WIDTH),
    )


@inner()
def _linked(uav: Uav, m: int) -> bool:
    return bool(m == uav.agent or uav.ages[m] == 0)


@inner()
def _cell(uav: Uav, m: int) -> int:
    """Return the cell of the UAV itself or of a linked teammate."""
    row, col = (uav.row, uav.col) if m == uav.agent else (uav.mates[m, 0], uav.mates[m, 1])
    return int(row * STRIDE + col)


@inner()
def _copy(source: np.ndarray, target: np.ndarray) -> None:
    for k in range(source.shape[0]):
        target[k] = source[k]


@leaf(entry=False)
def _first_views(start: int, uav: Uav, seen: np.ndarray, queue: np.ndarray, steps: np.ndarray, out: np.ndarray) -> None:
    """Write the steps from ``start`` after which each cell can be viewed, (256,); ``seen`` (4,) is scratch."""
    steps[:] = UNREACHABLE
    out[:] = NEVER
    seen[:] = np.uint64(0)
    steps[start], queue[0] = 0, start
    for place in range(flood_table(uav.passages, 1, queue, steps)):
        cell = queue[place]
        for w in range(WORDS):
            new = uav.views[cell, w] & ~seen[w]
            seen[w] |= new
            while new != 0:
                out[w * 64 + lowest(new)] = steps[cell]
                new &= new - _ONE


@leaf(entry=False)
def _assign(uav: Uav, work: DivisionScratch, unseen: np.ndarray) -> None:
    """Give each unseen cell to the linked UAV that views it first, at equal times to the lower number."""
    for cell in range(ROOM * STRIDE):
        work.owner[cell], least = -1, np.inf
        if holds(unseen, cell):
            for m in range(uav.ages.shape[0]):
                if _linked(uav, m) and work.first[m, cell] + work.delay[m] < least:
                    work.owner[cell], least = m, work.first[m, cell] + work.delay[m]


@leaf(entry=False)
def _take_part(work: DivisionScratch, m: int) -> int:
    """Write the cells of UAV ``m`` to ``work.part``; return their number."""
    size, part = 0, work.part
    part[:] = np.uint64(0)
    for cell in range(ROOM * STRIDE):
        if work.owner[cell] == m:
            insert(part, cell)
            size += 1
    return size


@leaf(entry=False)
def _measure(uav: Uav, work: DivisionScratch, aim: Aim) -> float:
    """Find a tour for the part of each linked UAV; return the length of the longest."""
    longest = 0.0
    for m in range(uav.ages.shape[0]):
        work.length[m] = 0.0
        if _linked(uav, m) and _take_part(work, m) > aim.rest:
            tour = shortest_tour(_cell(uav, m), work.part, uav.views, uav.passages, aim, work.beam)
            work.length[m] = tour.steps - 1.0  # the search counts the view from the start as a step
        longest = max(longest, work.length[m])
    return longest


@leaf(entry=False)
def _correct(uav: Uav, work: DivisionScratch, linked: int) -> None:
    """Delay the UAVs with long tours, and advance those with short ones."""
    mean = 0.0
    for m in range(uav.ages.shape[0]):
        mean += work.length[m] / linked
    for m in range(uav.ages.shape[0]):
        if _linked(uav, m):
            work.delay[m] += CORRECTION * (work.length[m] - mean)


@leaf(entry=False)
def _balance(uav: Uav, work: DivisionScratch, unseen: np.ndarray, aim: Aim, linked: int) -> None:
    """Divide the unseen cells so that the longest tour is short."""
    least = np.inf
    for _ in range(ROUNDS + 1):
        longest = _measure(uav, work, aim)
        if longest < least:
            least = longest
            _copy(work.delay, work.best)
        _correct(uav, work, linked)
        _assign(uav, work, unseen)
    _copy(work.best, work.delay)
    _assign(uav, work, unseen)


@leaf(entry=False)
def _leave(uav: Uav, work: DivisionScratch) -> None:
    """Note what linked teammates have got; write what is left to all teammates ever heard."""
    work.left[:] = np.uint64(0)
    for m in range(uav.ages.shape[0]):
        if uav.ages[m] == 0 and m != uav.agent:
            _take_part(work, m)
            _copy(work.part, uav.theirs[m])
        if uav.ages[m] >= 0 and m != uav.agent:
            for w in range(WORDS):
                work.left[w] |= uav.theirs[m, w]


@leaf(entry=False)
def divide(
    uav: Uav, work: DivisionScratch, unseen: np.ndarray, aim: Aim, queue: np.ndarray, steps: np.ndarray
) -> float:
    """Write the cells that are left to teammates to ``work.left``; return the UAV's share of what may stay unseen.

    ``unseen`` (4,) are the cells to divide, ``aim`` is that of the whole team. Each UAV that was ever heard has an
    equal share: 1 until one was. ``uav.theirs`` is updated; ``queue`` and ``steps`` (256,) are scratch.
    """
    linked, heard = 0, 0
    for m in range(uav.ages.shape[0]):
        work.delay[m] = 0.0
        heard += m == uav.agent or uav.ages[m] >= 0
        if _linked(uav, m):
            linked += 1
            _first_views(_cell(uav, m), uav, work.part, queue, steps, work.first[m])
    share = 1.0 / heard
    _assign(uav, work, unseen)
    if linked > 1:
        _balance(uav, work, unseen, Aim(aim.rest * share, aim.halfway, aim.isolation), linked)
    _leave(uav, work)
    return share
