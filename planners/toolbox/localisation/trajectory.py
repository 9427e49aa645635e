"""The path of one UAV as its map has it, and as the UAV estimates it from its own scans.

Maps draw scans at the poses that the UAV believes. A slip moves all scans after it, and a loop closure moves the scans
since the last pose as sure in proportion to the way flown, wherever in between the slip was. This keeps both poses of
each scan: ``drawn``, where the map has it, by the rules of
:mod:`~indoor_explorers.env.simulation.slam.localisation`, and ``places``, where it was made, with each slip at the step
at which the scans fit it best. All of it follows from the views.
"""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Mask
from indoor_explorers.env.grid.cells import MOVES, Action
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.localisation.scan_matching import (
    NO_SCAN,
    OFFSETS,
    REACH,
    OffsetFilter,
    Scan,
    consistency,
    offset_scores,
    scan_between,
)

#: Differences of variances below this are those of single precision.
TINY = 1e-5
#: Log-likelihood that a scan may lose by a slip right before it, and differences of fits that say nothing.
POSSIBLE, EQUAL = 1.0, 0.5
#: Most scans by which the time of a slip may be mistaken where the scans around it fit both places.
EARLIER = 30


class Trajectory:
    """Estimate one UAV's path; call :meth:`observe` once per step, and :meth:`expect` with each action."""

    def __init__(self, briefing: Briefing, doubted: float) -> None:
        self._reach, self._doubted = ceil(briefing.lidar_range) + 1, doubted
        self.rate = 0.0
        """Growth of the variance with each cell flown."""
        length = 64
        self.drawn = np.zeros((length, 2), np.int64)
        """(T, 2) cell from which the map has each scan."""
        self.places = np.zeros((length, 2), np.int64)
        """(T, 2) cell in which each scan was made, as estimated."""
        self.variance = np.zeros(length)
        """(T,) the variance of each pose."""
        self.way = np.zeros(length, np.int64)
        """(T,) cells flown before each scan."""
        self._scores = np.zeros((length, OFFSETS, OFFSETS))
        self._scans: list[Scan] = []
        self.log_odds = np.zeros(briefing.shape, np.float32)
        """(H, W) the map of the UAV's own scans at their estimated places."""
        self.filter = OffsetFilter()
        self._found: list[tuple[int, NDArray[np.int64]]] = []
        self.slips = 0
        """Slips found so far."""
        self.slip_at = 0
        """Number of the first scan after the last of them."""
        self._before = np.zeros(briefing.shape, np.float32)
        self._action = int(Action.STAY)
        self._linked: set[int] = set()

    def __len__(self) -> int:
        """Return the number of scans."""
        return len(self._scans)

    @property
    def cell(self) -> Cell:
        """Where the UAV is, as estimated."""
        row, col = self.places[len(self) - 1].tolist()
        return row, col

    @property
    def errors(self) -> Mask:
        """(T,) which scans the map has in another place than that of this estimate."""
        return np.asarray((self.drawn[: len(self)] != self.places[: len(self)]).any(axis=1))

    @property
    def error(self) -> Cell:
        """Rows and columns by which the UAV is away from where it believes to be, by this estimate."""
        down, right = (self.places[len(self) - 1] - self.drawn[len(self) - 1]).tolist()
        return down, right

    @property
    def is_off(self) -> bool:
        """Whether the UAV believes to be elsewhere than by this estimate."""
        return self.error != (0, 0)

    @property
    def scan(self) -> Scan:
        """The scan of this step; empty if it could not be told from other changes of the map."""
        return self._scans[-1]

    def missed(self, first: NDArray[np.int64], steps: NDArray[np.int32]) -> NDArray[np.float64]:
        """Return how many scans stay in, or get to, the wrong place if (K,) loops are closed, (K,).

        A loop is closed with scan ``first`` after so many ``steps``, and the correction of one cell is then made in the
        middle of the path since the last pose as sure.
        """
        known = self.variance[: len(self)]
        surer = [np.flatnonzero(known <= variance + TINY)[-1] for variance in self.variance[first]]
        middle = (self.way[np.array(surer, np.int64)] + self.way[len(self) - 1] + steps) / 2.0
        return np.asarray(np.abs(middle - self.way[self.slip_at]))

    def expect(self, action: int) -> None:
        """Note the action that the UAV takes."""
        self._action = action

    def observe(self, view: View, mate_error: Cell | None = None) -> None:
        """Take over the scan and the pose of this step.

        ``mate_error`` is how far a teammate in sight is from where it believes to be, by its own estimate, in rows and
        columns; None if no teammate is in sight.
        """
        if len(self) == 0:
            cell = np.array(view.cell)
            self._append(cell, cell, 0.0, 0, NO_SCAN)
        else:
            self._advance(view, mate_error)
        self._before = np.array(view.log_odds)

    def _advance(self, view: View, mate_error: Cell | None) -> None:
        """Add this step's scan and pose, and compare them with the path."""
        now, cell, variance = len(self), np.array(view.cell), view.pose_std**2
        grown = variance - self.variance[now - 1]
        self.rate = max(self.rate, grown)
        still = abs(grown) < TINY and bool((cell == self.drawn[now - 1]).all())
        closed = not still and grown < self.rate - TINY
        moved = not still and self._action < Action.STAY
        step = MOVES[self._action] if moved else np.zeros(2, np.int64)
        if moved and not closed:
            self.filter.move(min(1.0, self.rate))
        shift = cell - self.drawn[now - 1] - step
        redrawn = self._meets(view) or bool(shift.any())
        scan = NO_SCAN if redrawn else scan_between(self._before, np.array(view.log_odds), view.cell, self._reach)
        self._append(cell, self.places[now - 1] + step, variance, self.way[now - 1] + moved, scan)
        if closed:
            self._close(now, shift, mate_error)
        self._match(now)
        self._draw(now, now + 1, 1)

    def _append(
        self, drawn: NDArray[np.int64], place: NDArray[np.int64], variance: float, way: int, scan: Scan
    ) -> None:
        now = len(self)
        if now == len(self.drawn):
            for name in ("drawn", "places", "variance", "way", "_scores"):
                array = getattr(self, name)
                setattr(self, name, np.concatenate([array, np.zeros_like(array)]))
        self.drawn[now], self.places[now], self.variance[now], self.way[now] = drawn, place, variance, way
        self._scans.append(scan)

    def _meets(self, view: View) -> bool:
        """Tell whether a teammate has come into contact, whose scans are then all new."""
        linked = {mate.agent for mate in view.mates if mate.age == 0}
        new, self._linked = linked - self._linked, linked
        return bool(new)

    def _match(self, now: int) -> None:
        """Compare the last scan with the map of the others, and the estimate with what that says."""
        if len(self._scans[now].values):
            self._scores[now] = offset_scores(self.log_odds, self._scans[now], self.cell)
            self.filter.match(self._scores[now])
        if self.filter.doubt > self._doubted and self.filter.best != (0, 0):
            self._slip(1, now, np.array(self.filter.best))

    def _close(self, now: int, shift: NDArray[np.int64], mate_error: Cell | None) -> None:
        """Follow a correction of the map's path by ``shift``, and learn where the UAV is."""
        alike = np.abs(self.variance[:now] - self.variance[now]) < TINY
        same = np.flatnonzero(alike & (self.drawn[:now] == self.drawn[now]).all(axis=1))
        self._follow(now, shift)
        if len(same) == 0 and mate_error is None:
            return
        first = int(same[0]) if len(same) else 0
        place = self.places[first] if len(same) else self.drawn[now] + np.array(mate_error)
        offset = place - self.places[now]
        self.filter.recentre()
        if offset.any() and not (len(same) and self._was_earlier(first, offset)):
            self._slip(first + 1, now, offset)

    def _follow(self, now: int, shift: NDArray[np.int64]) -> None:
        """Spread a correction over the path since the last pose as sure, as the map does."""
        surer = np.flatnonzero(self.variance[:now] <= self.variance[now] + TINY)
        anchor = int(surer[-1]) if len(surer) else 0
        length = max(1, self.way[now] - self.way[anchor])
        share = (self.way[anchor + 1 : now] - self.way[anchor]) / length
        bridge = self.variance[now] + self.rate * length * share * (1.0 - share)
        self.variance[anchor + 1 : now] = np.minimum(self.variance[anchor + 1 : now], bridge)
        self.drawn[anchor + 1 : now] += np.floor(share[:, None] * shift + 0.5).astype(np.int64)

    def _was_earlier(self, first: int, offset: NDArray[np.int64]) -> bool:
        """Tell whether a slip found after scan ``first`` was before it, as a closure with it says; then move it."""
        for k, (number, found) in enumerate(self._found):
            if first < number <= first + EARLIER and (found == -offset).all():
                self._move(first, number, found)
                self._found[k] = first, found
                return True
        return False

    def _slip(self, first: int, now: int, offset: NDArray[np.int64]) -> None:
        """Move the places of the scans from a slip on, at the step since ``first`` where the scans fit it best."""
        row, col = np.clip(offset + REACH, 0, OFFSETS - 1)
        possible = first + np.flatnonzero(self._scores[first : now + 1, row, col] > -POSSIBLE)
        fits = self._fits(possible, now, offset)
        best = possible[fits >= fits.max() - EQUAL] if len(possible) else [now]
        self.slip_at = int(best[len(best) // 2])
        self.slips += 1
        self._found.append((self.slip_at, offset))
        self._move(self.slip_at, now, offset)
        self.places[now] += offset
        self.filter.recentre()

    def _fits(self, possible: NDArray[np.int64], now: int, offset: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return how well all scans up to ``now`` fit together for each of (K,) first moved ones, (K,)."""
        scans = self._scans[: now + 1]
        starts = np.concatenate([[0], np.cumsum([len(scan.values) for scan in scans])])
        cells = np.concatenate([scan.cells for scan in scans])
        cells += np.repeat(self.places[: now + 1], np.diff(starts), axis=0)
        values = np.concatenate([scan.values for scan in scans])
        empty = np.zeros_like(self.log_odds)
        return np.array([consistency(cells, values, starts, n, offset, empty.copy()) for n in possible.tolist()])

    def _move(self, first: int, last: int, offset: NDArray[np.int64]) -> None:
        """Move the places of the scans ``first`` to ``last`` - 1, and draw them again."""
        self._draw(first, last, -1)
        self.places[first:last] += offset
        self._draw(first, last, 1)

    def _draw(self, first: int, last: int, sign: int) -> None:
        """Add the scans ``first`` to ``last`` - 1 to the map of the UAV's own, or remove them."""
        height, width = self.log_odds.shape
        for number in range(first, last):
            scan = self._scans[number]
            rows, cols = (scan.cells + self.places[number]).T
            inside = (rows >= 0) & (rows < height) & (cols >= 0) & (cols < width)
            self.log_odds[rows[inside], cols[inside]] += sign * scan.values[inside]
