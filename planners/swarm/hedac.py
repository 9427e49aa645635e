"""HEDAC: gradient ascent on a potential field whose sources are the unexplored cells (Ivic, Crnkovic & Mezic 2017)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import OCCUPIED, UNKNOWN, Action
from indoor_explorers.env.grid.compiled import inner, leaf
from indoor_explorers.env.grid.levels import beside, degree, offset, target_of
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.coordination.independent_pilot import IndependentPilot
from indoor_explorers.planners.toolbox.navigation.teammates import claims, remembered
from indoor_explorers.planners.toolbox.parameters import Parameters, bounded

#: Temperatures below this are too close to the smallest floats for a gradient.
COLD = 1e-280
#: Sweeps before the first check whether the field has an ascent.
FIRST_SWEEPS = 4
#: Mark, in a field of heat sources, of a cell with a fixed u = 0.
SINK = -1.0


@dataclass(frozen=True, kw_only=True)
class Hedac(Parameters, Policy):
    """Ascend a potential field: the stationary temperature with a heat source in every unexplored cell.

    At every passable cell u = (sum of the passable neighbours' u + s) / (n + loss), n their number and s the cell's
    heat source: 1 if it is unknown, less within the lidar range of a teammate's goal (the paper's cooling). Walls
    insulate, and the cells of teammates are fixed at 0 (its collision avoidance). A known cell is colder than its
    warmest neighbour, so the ascent in the converged field ends at an unknown cell. This cell is kept as the goal until
    it is explored; a new ascent at every step was no better.

    With a loss of 10, u falls by a factor of some 14 per cell, which reaches the smallest floats after 250 cells. Where
    u is too small for an ascent, or has not converged within ``sweeps``, the UAV flies to its nearest frontier cell
    instead, so it never stands still; the tally counts this (``cold_starts``). Weaknesses: the field ignores lines of
    sight, so a wide view counts no more than a narrow one, and a pocket left behind gets colder with every step away.

    S. Ivic, B. Crnkovic, I. Mezic, "Ergodicity-based cooperative multiagent area coverage via a potential field",
    IEEE Transactions on Cybernetics 47(8), 2017, doi:10.1109/TCYB.2016.2634400; on grids that grow: B. Crnkovic,
    S. Ivic, M. Zovko, "Fast algorithm for centralized multi-agent maze exploration", arXiv:2310.02121.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    loss: float = bounded(10.0, least=1e-6, tunable=(0.1, 100.0, "log"))
    """Heat that a cell loses relative to the exchange with one neighbour, the paper's alpha; a smaller loss gives the
    field a longer range. 1 was as good as the published 10; .1 and .01 were slower in rooms."""
    sweeps: int = bounded(100, least=1)
    """Most sweeps over the map for a decision; they start from the last field and stop when it has an ascent."""
    cooling: float = bounded(0.9, least=0, most=1, tunable=(0.0, 1.0))
    """Share by which a teammate's goal reduces the heat sources in its lidar range, 0 to 1."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return HedacPilot(briefing, self)


@leaf()
def heat_up(
    belief: np.ndarray, claims: np.ndarray, radius: float, kept: float, sinks: np.ndarray, out: np.ndarray, rise: int
) -> None:
    """Fill ``out`` (H, W) with the heat source of each cell, ``SINK`` at those of the (M, 2) ``sinks``.

    The source of unknown cells within ``radius`` of one of the (C, 2) ``claims`` is ``kept`` instead of 1.
    """
    height, width = belief.shape
    for row in range(height):
        for col in range(width):
            out[row, col] = 1.0 if belief[row, col] == UNKNOWN else 0.0
            for m in range(claims.shape[0] if out[row, col] > 0.0 else 0):
                levels, rows, cols = offset(int(claims[m, 0]), int(claims[m, 1]), row, col, rise)
                if levels * levels + rows * rows + cols * cols <= radius * radius:
                    out[row, col] = kept
    for m in range(sinks.shape[0]):
        out[sinks[m, 0], sinks[m, 1]] = SINK


@inner()
def _settle(u: np.ndarray, belief: np.ndarray, heat: np.ndarray, loss: float, row: int, col: int, rise: int) -> None:
    """Update the temperature of a cell from its neighbours."""
    height, width = belief.shape
    if belief[row, col] == OCCUPIED or heat[row, col] == SINK:
        u[row, col] = 0.0
        return
    total, count = heat[row, col], 0
    for k in range(degree(rise)):
        r, c = beside(row, col, k, rise)
        if 0 <= r < height and 0 <= c < width and belief[r, c] != OCCUPIED:
            total += u[r, c]
            count += 1
    u[row, col] = total / (count + loss)


@leaf()
def sweep(u: np.ndarray, belief: np.ndarray, heat: np.ndarray, loss: float, rise: int = 0) -> None:
    """Update every cell of the (H, W) field ``u`` once forwards and once backwards (symmetric Gauss-Seidel)."""
    height, width = belief.shape
    for row in range(height):
        for col in range(width):
            _settle(u, belief, heat, loss, row, col, rise)
    for row in range(height - 1, -1, -1):
        for col in range(width - 1, -1, -1):
            _settle(u, belief, heat, loss, row, col, rise)


@leaf()
def climb(u: np.ndarray, belief: np.ndarray, row: int, col: int, rise: int = 0) -> int:
    """Return the last known flat cell of the steepest ascent from (row, col) to an unknown cell, -1 for none."""
    height, width = belief.shape
    while True:
        top, best = -1, max(u[row, col], COLD)
        for k in range(degree(rise)):
            r, c = beside(row, col, k, rise)
            if 0 <= r < height and 0 <= c < width and belief[r, c] != OCCUPIED and u[r, c] > best:
                top, best = k, u[r, c]
        if top < 0:
            return -1
        r, c = beside(row, col, top, rise)
        if belief[r, c] == UNKNOWN:
            return int(row * width + col)
        row, col = r, c


class HedacPilot(IndependentPilot):
    """Update a temperature field and fly to the end of its steepest ascent."""

    changes_levels: ClassVar[bool] = True
    straight = False
    fallback_figure = "cold_starts"

    def __init__(self, briefing: Briefing, policy: Hedac) -> None:
        super().__init__(briefing)
        self._policy = policy
        self._field = np.zeros(briefing.shape)
        self._heat = np.zeros(briefing.shape)

    def chosen(self, view: View) -> Cell | None:
        """Return the frontier cell at the end of the ascent; None if there is no ascent, or the cell is banned."""
        end = self._ascent(view)
        if self.explaining:
            self._compare_ascents(view)
        if end < 0 or self.near_banned(view, np.array([end], np.int32)).any():
            return None
        return divmod(end, self.paths.width)

    def _ascent(self, view: View) -> int:
        policy, rise = self._policy, self.paths.rise
        claimed = claims(view, self.briefing)
        heat_up(view.belief, claimed, self._lidar, 1.0 - policy.cooling, self._sinks(view), self._heat, rise)
        for done in range(1, policy.sweeps + 1):
            sweep(self._field, view.belief, self._heat, policy.loss, rise)
            if done >= min(FIRST_SWEEPS, policy.sweeps):
                end = climb(self._field, view.belief, *view.cell, rise)
                if end >= 0:
                    return end
        return -1

    def _compare_ascents(self, view: View) -> None:
        """Consider where the ascents through the neighbouring cells end; the warmest neighbour leads to the goal."""
        rise, moves = self.paths.rise, np.flatnonzero(view.legal).tolist()
        around = [target_of(view.cell, move, rise) for move in moves if move != Action.STAY]
        warmth = {cell: float(self._field[cell]) for cell in around if self._field[cell] > COLD}
        ends = {cell: climb(self._field, view.belief, *cell, rise) for cell in sorted(warmth, key=warmth.__getitem__)}
        best = {end: cell for cell, end in ends.items() if end >= 0}  # the warmest one last
        cells = np.array(list(best), np.int32)
        steps = self.steps_from(view, view.cell).ravel()[cells]
        self.consider(cells, "temperature of the first cell", [warmth[cell] for cell in best.values()], steps=steps)

    def _sinks(self, view: View) -> NDArray[np.int64]:
        cells = [mate.cell for mate in remembered(view, self.briefing) if mate.cell != view.cell]
        return np.array(cells, np.int64).reshape(-1, 2)
