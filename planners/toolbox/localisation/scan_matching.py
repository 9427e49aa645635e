"""Scan matching on a grid: how well a scan fits a map at each small offset, and a histogram filter of the pose error.

Markov localisation (D. Fox, W. Burgard, S. Thrun, "Active Markov localization for mobile robots", RAS 1998,
doi:10.1016/S0921-8890(98)00049-9) over offsets of a few cells, the pose error since the last estimate.
"""

from __future__ import annotations

from math import log, tanh
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.compiled import inner, kernel
from indoor_explorers.env.sensing.inverse_model import CERTAIN, HIT, PASS

#: Largest offset along rows and columns, and the number of offsets along each.
REACH = 2
OFFSETS = 2 * REACH + 1
#: Likelihood of a reading that contradicts a certain cell.
CONTRADICTED = 0.1
#: Log-likelihood of a reading of a wall where nothing is known: of two paths, that with fewer walls is more probable.
NEW_WALL = -0.05


#: The log-odds of one reading.
READINGS = np.array([HIT, PASS, CERTAIN * HIT, CERTAIN * PASS], np.float32)


class Scan(NamedTuple):
    """Readings of one scan, relative to the UAV's cell."""

    cells: NDArray[np.int64]
    """(K, 2) rows and columns from the UAV's cell."""
    values: NDArray[np.float32]
    """(K,) log-odds of each."""


NO_SCAN = Scan(np.empty((0, 2), np.int64), np.empty(0, np.float32))


def scan_between(before: NDArray[np.float32], after: NDArray[np.float32], cell: Cell, reach: int) -> Scan:
    """Return the scan whose readings turned one (H, W) map of log-odds into the next, made in ``cell``.

    Other changes, such as those by a teammate's scan, are ignored: only those of one reading count, at most ``reach``
    cells away.
    """
    top, left = max(0, cell[0] - reach), max(0, cell[1] - reach)
    window = slice(top, cell[0] + reach + 1), slice(left, cell[1] + reach + 1)
    change = after[window] - before[window]
    rows, cols = np.nonzero(np.isin(change, READINGS))
    return Scan(np.stack([rows + (top - cell[0]), cols + (left - cell[1])], axis=1), change[rows, cols])


def offset_scores(log_odds: NDArray[np.float32], scan: Scan, cell: Cell) -> NDArray[np.float64]:
    """Return the log-likelihood of a scan made at each offset from ``cell``, (OFFSETS, OFFSETS), at most 0.

    Only readings that contradict the (H, W) map count: those that agree would favour offsets that look back, where
    more is known.
    """
    certainty = np.tanh(np.pad(log_odds, REACH) / 2.0)
    rows, cols = (scan.cells + cell).T
    inside = (rows >= 0) & (rows < log_odds.shape[0]) & (cols >= 0) & (cols < log_odds.shape[1])
    rows, cols, sign = rows[inside], cols[inside], np.sign(scan.values[inside])
    steps = np.arange(OFFSETS)
    known = certainty[steps[:, None, None] + rows, steps[None, :, None] + cols]
    against = np.maximum(0.0, -sign * known)
    return np.asarray(np.log(1.0 - (1.0 - CONTRADICTED) * against).sum(axis=2), np.float64)


class OffsetFilter:
    """The probability of each offset of the UAV from where it is estimated to be."""

    def __init__(self) -> None:
        self.recentre()

    def recentre(self) -> None:
        """Be certain that the estimate is right."""
        self.chances = np.zeros((OFFSETS, OFFSETS))
        self.chances[REACH, REACH] = 1.0
        """(OFFSETS, OFFSETS) the probabilities."""

    def move(self, slip: float) -> None:
        """Consider a slip to one of the four neighbours, with this probability."""
        around = np.pad(self.chances, 1)
        beside = around[:-2, 1:-1] + around[2:, 1:-1] + around[1:-1, :-2] + around[1:-1, 2:]
        mixed = (1.0 - slip) * self.chances + slip / 4.0 * beside
        self.chances = mixed / mixed.sum()

    def match(self, scores: NDArray[np.float64]) -> None:
        """Weigh the offsets by the log-likelihoods of a scan."""
        weighed = self.chances * np.exp(scores - scores.max())
        self.chances = weighed / weighed.sum()

    @property
    def doubt(self) -> float:
        """Probability that the estimate is wrong."""
        return float(1.0 - self.chances[REACH, REACH])

    @property
    def best(self) -> Cell:
        """The most probable offset, in rows and columns."""
        row, col = divmod(int(self.chances.argmax()), OFFSETS)
        return row - REACH, col - REACH


@inner()
def _surprise(log_odds: float, value: float) -> float:
    """Return the log-likelihood of a reading of a cell: 0 unless it contradicts, or is of a wall not known yet."""
    if log_odds == 0.0:
        return NEW_WALL if value > 0.0 else 0.0
    against = tanh(-log_odds / 2.0 if value > 0.0 else log_odds / 2.0)
    return log(1.0 - (1.0 - CONTRADICTED) * max(0.0, against))


@kernel()
def consistency(
    cells: np.ndarray, values: np.ndarray, starts: np.ndarray, first: int, offset: np.ndarray, log_odds: np.ndarray
) -> float:
    """Return how well T scans fit together if those from number ``first`` on are moved by ``offset``.

    ``cells`` (K, 2) and ``values`` (K,) are the readings of all, those of scan n from ``starts[n]`` on, and
    ``log_odds`` (H, W) is a map of zeros to draw on. Each scan is compared with the map of those before.
    """
    height, width = log_odds.shape
    total = 0.0
    for number in range(starts.shape[0] - 1):
        down, right = (offset[0], offset[1]) if number >= first else (0, 0)
        for k in range(starts[number], starts[number + 1]):
            row, col = cells[k, 0] + down, cells[k, 1] + right
            if 0 <= row < height and 0 <= col < width:
                total += _surprise(log_odds[row, col], values[k])
                log_odds[row, col] += values[k]
    return total
