"""Rollouts: fly tours in sampled rooms to the end, to find the one that obstacles delay least.

A tour assumes that every unknown cell is free. In each sampled room, which agrees with the belief, it is flown while it
is free, for some steps at most; then a fast policy takes over: the next step towards the cell with the largest
g e^(-decay d), where g is the weight in view, increased by the known cells around each unseen one, and d the steps to
it. All tours are flown in the same rooms, which reduces the variance of their differences (rollouts: G. Tesauro and
G. Galperin, NeurIPS 1996; D. P. Bertsekas and D. A. Castanon 1999, doi:10.1023/A:1009634810396).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN, UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.search.bfs import distances_from
from indoor_explorers.env.search.bitsets import lowest
from indoor_explorers.env.sensing.lidar import LidarModel, Scan, new_scan, visible_cells

#: Most steps of a tour that are flown before the fast policy takes over.
FOLLOWED = 12
#: Additional weight of an unseen cell for each known one in the 5x5 around it, in the fast policy.
ISOLATION = 1 / 3
#: Discount rate per step in the fast policy.
DECAY = 0.5
#: Steps after which a flight is given up.
LONGEST = 120
_ONE = np.uint64(1)


class RolloutSetup(NamedTuple):
    """The knowledge before a rollout, C cells in W words."""

    belief: NDArray[np.uint8]
    """(H, W)."""
    chances: NDArray[np.float64]
    """(C,) probability that an unknown cell is free and reachable, 0 for others."""
    views: NDArray[np.uint64]
    """(C, W) cells visible from a cell."""
    neighbours: NDArray[np.int32]
    """(C, 4) neighbours, -1 for none."""
    surroundings: NDArray[np.int32]
    """(C, 24) the 5x5 around a cell, -1 off the map."""


class Rollout(NamedTuple):
    """Working arrays of one rollout, (C,) each."""

    belief: np.ndarray
    weights: np.ndarray
    """Weight of seeing a cell, 0 once it is known."""
    visited: np.ndarray
    steps: np.ndarray
    """Steps from the UAV, -1 without a known path."""
    first: np.ndarray
    """First cell of the path."""
    queue: np.ndarray


@kernel(entry=False)
def _new_rollout(cells: int) -> Rollout:
    return Rollout(
        np.empty(cells, np.uint8),
        np.empty(cells),
        np.empty(cells, np.bool_),
        np.empty(cells, np.int32),
        np.empty(cells, np.int32),
        np.empty(cells, np.int32),
    )


@kernel(entry=False)
def _weights(setup: RolloutSetup) -> np.ndarray:
    """Return the weight of seeing each cell in the fast policy, (C,)."""
    belief = setup.belief.ravel()
    weights = np.zeros(belief.shape[0])
    for cell in np.flatnonzero(belief == UNKNOWN):
        known = 0
        for near in setup.surroundings[cell]:
            known += near < 0 or belief[near] != UNKNOWN
        weights[cell] = setup.chances[cell] * (1 + ISOLATION * known)
    return weights


@kernel(entry=False)
def _reveal(rollout: Rollout, setup: RolloutSetup, cell: int, room: np.ndarray, lidar: LidarModel, scan: Scan) -> int:
    """Scan a (H, W) room from a flat cell; return the number of new free cells."""
    height, width = room.shape
    truth, found = room.reshape(height * width), 0
    rollout.visited[cell] = True
    for k in range(visible_cells(room, cell // width, cell % width, lidar, scan)):
        seen = scan.cells[k]
        if rollout.belief[seen] == UNKNOWN:
            rollout.belief[seen], rollout.weights[seen] = truth[seen], 0.0
            found += truth[seen] == FREE
            for near in setup.surroundings[seen]:
                if near >= 0 and rollout.belief[near] == UNKNOWN:
                    rollout.weights[near] += ISOLATION * setup.chances[near]
    return found


@kernel(entry=False)
def _gain(weights: np.ndarray, view: np.ndarray) -> float:
    """Return the weight of the cells of a set (W,)."""
    gain = 0.0
    for w in range(view.shape[0]):
        word = view[w]
        while word != 0:
            gain += weights[w * 64 + lowest(word)]
            word &= word - _ONE
    return gain


@kernel(entry=False)
def _quick_step(rollout: Rollout, setup: RolloutSetup, start: int, most: float) -> int:
    """Return the next cell of the fast policy, -1 if nothing is left to see.

    The search stores the first cell of each path and ends as soon as no farther cell can be better; ``most`` is an
    upper bound of a view's gain.
    """
    rollout.steps[:] = -1
    rollout.steps[start], rollout.queue[0] = 0, start
    head, tail, best, following = 0, 1, 0.0, -1
    while head < tail:
        cell = rollout.queue[head]
        head += 1
        fade = np.exp(-DECAY * rollout.steps[cell])
        if most * fade <= best:
            break
        if not rollout.visited[cell] and cell != start:
            worth = fade * _gain(rollout.weights, setup.views[cell])
            if worth > best:
                best, following = worth, rollout.first[cell]
        for near in setup.neighbours[cell]:
            if near >= 0 and rollout.steps[near] < 0 and rollout.belief[near] != OCCUPIED:
                rollout.steps[near] = rollout.steps[cell] + 1
                rollout.first[near] = near if cell == start else rollout.first[cell]
                rollout.queue[tail] = near
                tail += 1
    return int(following)


@kernel(entry=False)
def _fly(
    rollout: Rollout,
    setup: RolloutSetup,
    start: int,
    tour: np.ndarray,
    room: np.ndarray,
    wanted: np.ndarray,
    lidar: LidarModel,
) -> np.ndarray:
    """Return the steps after which each number of new free cells in ``wanted`` (N,), ascending, was seen, (N,)."""
    scan, most = new_scan(lidar), (lidar.disc + 1) * (1 + 24 * ISOLATION)
    steps = np.full(wanted.shape[0], LONGEST, np.int64)
    cell, found, follows = start, 0, True
    for step in range(1, LONGEST):
        follows = follows and step <= min(tour.shape[0], FOLLOWED)
        follows = follows and tour[step - 1] >= 0 and rollout.belief[tour[step - 1]] != OCCUPIED
        cell = tour[step - 1] if follows else _quick_step(rollout, setup, cell, most)
        if cell < 0 or room.reshape(room.size)[cell] == OCCUPIED:
            break
        found += _reveal(rollout, setup, cell, room, lidar, scan)
        for n in range(wanted.shape[0]):
            if found >= wanted[n]:
                steps[n] = min(steps[n], step)
        if found >= wanted[-1]:
            break
    return steps


@kernel()
def _fly_all(
    start: int, setup: RolloutSetup, tours: np.ndarray, rooms: np.ndarray, shares: np.ndarray, lidar: LidarModel
) -> np.ndarray:
    cells, weights, known = setup.belief.size, _weights(setup), setup.belief.ravel() == FREE
    rollout = _new_rollout(cells)
    queue, distances = np.empty(cells, np.int32), np.empty(setup.belief.shape, np.int32)
    steps = np.empty((tours.shape[0], rooms.shape[0], shares.shape[0]), np.int64)
    for s in range(rooms.shape[0]):
        room = rooms[s].reshape(setup.belief.shape)
        size = distances_from(room, start // room.shape[1], start % room.shape[1], queue, distances)
        wanted = shares * size - (known & (distances.ravel() < UNREACHABLE)).sum()
        for t in range(tours.shape[0]):
            rollout.belief[:] = setup.belief.ravel()
            rollout.weights[:] = weights
            rollout.visited[:] = False
            steps[t, s] = _fly(rollout, setup, start, tours[t], room, wanted, lidar)
    return steps


def steps_to_shares(
    start: int,
    setup: RolloutSetup,
    tours: list[list[int]],
    rooms: Belief,
    shares: NDArray[np.float64],
    lidar: LidarModel,
) -> NDArray[np.int64]:
    """Return the steps after which flights reach given coverages of rooms, (T, S, N).

    Args:
        start: The UAV's flat cell.
        setup: Its knowledge.
        tours: T lists of flat cells, without the start.
        rooms: (S, C) rooms without unknown cells that agree with the belief.
        shares: (N,) shares of a room's reachable cells, ascending. One that is not reached takes ``LONGEST`` steps.
        lidar: The lidar.
    """
    padded = np.full((len(tours), FOLLOWED), -1, np.int32)
    for row, tour in zip(padded, tours, strict=True):
        row[: len(tour)] = tour[:FOLLOWED]
    return np.asarray(_fly_all(start, setup, padded, rooms, shares, lidar))
