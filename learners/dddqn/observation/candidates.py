"""Candidate features of the moves on maps of any size: the best next viewpoint in the direction of each move.

A candidate (in the setting and in arrays: prospect) is a frontier cell. Its utility is g^power e^(-rate d), with g its
view gain and d the path length to it in lidar ranges (H. H. Gonzalez-Banos, J.-C. Latombe, IJRR 2002,
doi:10.1177/0278364902021010834). There are two kinds: the gain of the first counts all unknown cells alike, that of the
second gives isolated cells more weight and leaves fewer pockets behind. A move is behind the best one by the additional
path length that would explain the lower utility of its best candidate: log(utility ratio) / rate, in steps at the
reference range.

A candidate near the best one of the last observation gets a bonus, so that a UAV does not change its goal at every
step. A candidate that a recently heard teammate is closer to is worth little, as in MinPos (A. Bautin, O. Simonin,
F. Charpillet, ICIRA 2012, doi:10.1007/978-3-642-33515-0_49).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.grid.compiled import leaf
from indoor_explorers.env.search.bfs import flood
from indoor_explorers.env.search.frontiers import touches_unknown
from indoor_explorers.learners.dddqn.observation.layout import BEYOND, PROSPECT, PROSPECTS
from indoor_explorers.learners.dddqn.observation.map_image import HALF_DISTANCE
from indoor_explorers.learners.dddqn.observation.scales import REFERENCE_RANGE, Scratch, Sensor
from indoor_explorers.learners.dddqn.observation.uav import Uav

#: For each kind: exponent of the view gain, and discount rate of the path length per lidar range.
POWERS, RATES = (1.0, 0.5), (1.5, 0.8)
#: Hysteresis: Chebyshev distance to the last best candidate, in lidar ranges, within which the utility gets a factor;
#: this factor.
NEAR, HOLD = 0.4, 1.2
#: Largest age of a recent position of a teammate, in steps per cell of the lidar range; factor on the utility of a
#: candidate that such a teammate is closer to.
HEARD, THEIRS = 3.0, 0.05
_THERE, _BEHIND, _BEST, _WAY, _VIEW = range(len(PROSPECT))


class CandidateScratch(NamedTuple):
    """Working arrays of the search for candidates, for maps of one shape and K = 2 kinds."""

    theirs: NDArray[np.int32]
    """(H, W) path length of the nearest recently heard teammate in steps."""
    worth: NDArray[np.float64]
    """(K, 4) utility of the best candidate in the direction of each move, for each kind."""
    steps: NDArray[np.int64]
    """(K, 4) path length to it after the move, in steps."""
    cell: NDArray[np.int64]
    """(K, 4) its flat cell."""


def new_candidate_scratch(shape: tuple[int, int]) -> CandidateScratch:
    """Allocate the arrays for (H, W) maps."""
    best = (len(PROSPECTS), 4)
    return CandidateScratch(
        np.zeros(shape, np.int32), np.zeros(best), np.zeros(best, np.int64), np.zeros(best, np.int64)
    )


@leaf(entry=False)
def _flood_from_teammates(
    belief: np.ndarray, mates: np.ndarray, ages: np.ndarray, most: float, queue: np.ndarray, theirs: np.ndarray
) -> None:
    """Fill ``theirs`` with the distances from teammates that were heard up to ``most`` steps ago."""
    tail = 0
    theirs[:] = UNREACHABLE
    for m in range(ages.shape[0]):
        row, col = mates[m, 0], mates[m, 1]
        if 0 <= ages[m] <= most and theirs[row, col] != 0:
            theirs[row, col], queue[tail] = 0, row * belief.shape[1] + col
            tail += 1
    flood(belief, FREE, tail, queue, theirs)


@leaf(entry=False)
def _compare(
    kind: int,
    cell: int,
    steps: int,
    first: int,
    view: float,
    factor: float,
    lidar_range: float,
    candidates: CandidateScratch,
) -> None:
    """Update the best candidates of all moves with one that is ``steps`` steps away.

    ``first`` are the moves, one bit each, that begin a shortest path to it.
    """
    here = factor * view ** POWERS[kind]
    for k in range(4):
        way = steps - 1 if first >> k & 1 else steps + 1
        worth = here * np.exp(-RATES[kind] * way / lidar_range)
        if worth > candidates.worth[kind, k]:
            candidates.worth[kind, k], candidates.steps[kind, k], candidates.cell[kind, k] = worth, way, cell


@leaf(entry=False)
def _write(
    kind: int, gain: np.ndarray, sensor: Sensor, blocked: np.ndarray, candidates: CandidateScratch, out: np.ndarray
) -> int:
    """Write one kind's five features of each move into ``out`` (4, 5); return the best candidate's flat cell or -1."""
    best, most = -1, 0.0
    for k in range(4):
        if blocked[k] == 0 and candidates.worth[kind, k] > most:
            best, most = k, candidates.worth[kind, k]
    for k in range(4):
        worth, way = candidates.worth[kind, k], candidates.steps[kind, k] * sensor.rate
        out[k, :] = 0.0
        if blocked[k] or worth <= 0.0:
            out[k, _BEHIND] = 1.0 if best >= 0 else 0.0
            continue
        behind = REFERENCE_RANGE * np.log(most / worth) / RATES[kind]
        row, col = divmod(candidates.cell[kind, k], gain.shape[1])
        out[k, _THERE], out[k, _BEHIND], out[k, _BEST] = 1.0, min(behind / BEYOND, 1.0), 1.0 if worth == most else 0.0
        out[k, _WAY], out[k, _VIEW] = way / (way + HALF_DISTANCE), np.sqrt(gain[row, col] / sensor.disc)
    return int(candidates.cell[kind, best]) if best >= 0 else -1


@leaf(entry=False)
def write_candidates(uav: Uav, sensor: Sensor, scratch: Scratch, candidates: CandidateScratch, out: np.ndarray) -> None:
    """Write the candidate features of a UAV's four moves into ``out`` (4, 10).

    The gains must be flooded before. ``uav.prospect``, the best candidates, is updated.
    """
    belief, gain, weight, kept = uav.belief, uav.gain, uav.weight, uav.prospect
    width, lidar_range = belief.shape[1], REFERENCE_RANGE / sensor.rate
    _flood_from_teammates(belief, uav.mates, uav.ages, HEARD * lidar_range, scratch.queue, candidates.theirs)
    candidates.worth[:] = 0.0
    for row in range(belief.shape[0]):
        for col in range(width):
            steps, found = scratch.steps[row, col], gain[row, col]
            if steps < 0 or found <= 0 or not touches_unknown(belief, row, col):
                continue
            share = THEIRS if candidates.theirs[row, col] <= steps else 1.0
            for kind in range(len(POWERS)):
                r, c = divmod(kept[kind], width)
                held = kept[kind] >= 0 and max(abs(row - r), abs(col - c)) <= NEAR * lidar_range
                view = float(found) if kind == 0 else float(weight[row, col])
                factor = share * HOLD if held else share
                _compare(kind, row * width + col, steps, scratch.first[row, col], view, factor, lidar_range, candidates)
    for kind in range(len(POWERS)):
        part = out[:, kind * len(PROSPECT) : (kind + 1) * len(PROSPECT)]
        kept[kind] = _write(kind, gain, sensor, scratch.blocked, candidates, part)
