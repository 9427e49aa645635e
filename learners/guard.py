"""The oscillation guard: hands over to the nearest frontier when a learned policy goes nowhere.

A greedy network can oscillate between two cells for ever. The guard leaves control to the network while the UAV
gains new cells. It takes over when there was no gain for twice the path length to the nearest frontier (at least
:data:`PATIENCE` steps), or when the UAV oscillates between two cells. Then it flies to the nearest frontier
(Yamauchi 1997) until the UAV gains a cell, so that every episode ends. After each takeover, the next one comes
sooner and lasts longer, so that a network which fails on a map needs few steps more than the nearest frontier alone.
Gains under the network's control earn credit; enough credit undoes a takeover.

Behind a teammate in the way the UAV backs off at random, longer with every retreat, so that two UAVs in a corridor
do not wait for each other for ever. Planners resolve deadlocks in another way
(:mod:`indoor_explorers.planners.toolbox.navigation.deadlock`), which needs a planned path.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import FREE, MOVES, UNKNOWN, Action
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.policies.explanation import Explanation
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.search.bfs import distances_from, step_towards
from indoor_explorers.env.search.frontiers import touches_unknown
from indoor_explorers.env.sensing.lidar import LidarModel, Scan, lidar_model, new_scan, visible_cells

#: Steps without a gain before which the guard never takes over.
PATIENCE = 8
#: Largest number of takeovers that is counted.
MOST_TAKEOVERS = 9
#: Gains under the policy's control that undo one takeover.
CREDIT = 64
#: Returns in a row to the cell before the last one, before the guard takes over.
OSCILLATIONS = 3
#: Blocked moves in a row before the UAV backs off; a UAV that follows another one is blocked now and then.
BUMPS = 2
#: Longest wait, in steps, at the cell that the UAV has backed off to.
LONGEST_WAIT = 4


@kernel()
def nearest_frontier(belief: np.ndarray, row: int, col: int, queue: np.ndarray, steps: np.ndarray) -> int:
    """Return the flat index of the nearest known free cell next to an unknown one, -1 when none is reachable.

    Fills ``steps`` (H, W) int32 with the distances from (row, col); ``queue`` (H*W,) int32 is scratch.
    """
    for i in range(distances_from(belief, row, col, queue, steps)):
        r, c = divmod(queue[i], belief.shape[1])
        if touches_unknown(belief, r, c):
            return int(queue[i])
    return -1


@leaf()
def discovered(belief: np.ndarray, row: int, col: int, lidar: LidarModel, scan: Scan, noted: np.ndarray) -> int:
    """Count the known cells in view of a UAV that ``noted`` (H, W) uint8 lacks: its own lidar discovered them.

    Newly known cells outside its view came by radio; they are no progress of this UAV.
    """
    found = 0
    for k in range(visible_cells(belief, row, col, lidar, scan)):
        r, c = divmod(scan.cells[k], belief.shape[1])
        found += belief[r, c] != UNKNOWN and noted[r, c] == 0
    return found


class Guard:
    """Watch one UAV for one episode and replace its moves when they lead nowhere."""

    def __init__(self, shape: tuple[int, int], rng: np.random.Generator) -> None:
        self.guarded = self.decisions = 0
        self._rng = rng
        self._steps = np.empty(shape, np.int32)
        self._queue = np.empty(shape[0] * shape[1], np.int32)
        self._gained = self._idle = self._limit = self._bumps = self._retreats = 0
        self._takeovers = self._takeover_steps = self._credit = 0
        self._oscillations = 0
        self._trail: tuple[Cell | None, Cell | None] = (None, None)
        self._last: tuple[Cell, int] | None = None
        self._retreat_cell: Cell | None = None
        self._detour = 0

    @property
    def share(self) -> float:
        """Share of the decisions that were not the policy's own."""
        return self.guarded / max(self.decisions, 1)

    def review(self, view: View, gained: int, proposal: int) -> int:
        """Return the move to make: ``proposal`` or the guard's own.

        ``gained`` is the number of cells that the UAV's own lidar has discovered so far.
        """
        self.decisions += 1
        self._count_oscillations(view.cell)
        self._update_progress(view, gained)
        self._bumps = self._bumps + 1 if self._was_blocked(view) else 0
        if self._bumps >= BUMPS:
            self._retreats += 1
            self._back_off(view)
        action = self._own_move(view)
        self.guarded += action is not None
        chosen = proposal if action is None else action
        self._last = (view.cell, chosen) if view.legal[chosen] else None  # walls do not count as blocked
        return chosen

    def rest(self) -> None:
        """Note that the UAV stays because it can reach no frontier."""
        self._last = None

    def _count_oscillations(self, cell: Cell) -> None:
        before_last, last = self._trail
        self._oscillations = self._oscillations + 1 if cell == before_last and cell != last else 0
        self._trail = last, cell

    def _update_progress(self, view: View, gained: int) -> None:
        if gained > self._gained:
            self._gained, self._idle, self._retreats, self._detour = gained, 0, 0, 0
            self._earn_credit()
            return
        self._idle += 1
        if self._idle == 1:
            goal = self._frontier(view)
            way = 2 * int(self._steps.flat[goal]) if goal >= 0 else 0
            self._limit = max(PATIENCE, way >> self._takeovers)
        if self._oscillations > OSCILLATIONS:
            self._limit = min(self._limit, self._idle - 1)
        if self._idle == self._limit + 1 and self._takeover_steps == 0:
            self._takeovers = min(self._takeovers + 1, MOST_TAKEOVERS)
            self._takeover_steps = 2**self._takeovers - 2

    def _earn_credit(self) -> None:
        """Count a gain under the policy's control; :data:`CREDIT` of them undo a takeover."""
        if self._takeover_steps > 0:
            return
        self._credit += 1
        if self._credit >= CREDIT:
            self._takeovers, self._credit = max(self._takeovers - 1, 0), 0

    def _was_blocked(self, view: View) -> bool:
        return self._last is not None and self._last[1] != Action.STAY and self._last[0] == view.cell

    def _own_move(self, view: View) -> int | None:
        """Return the guard's move; None while the policy is in control."""
        if self._detour > 0:
            self._detour -= 1
            return self._towards_retreat(view)
        if self._idle > self._limit:
            return self._towards_frontier(view)
        if self._takeover_steps > 0:
            self._takeover_steps -= 1
            return self._towards_frontier(view)
        return None

    def finished(self, view: View) -> bool:
        """Tell whether the UAV can reach no frontier."""
        return self._frontier(view) < 0

    def _frontier(self, view: View) -> int:
        return int(nearest_frontier(view.belief, *view.cell, self._queue, self._steps))

    def _towards_frontier(self, view: View) -> int:
        goal = self._frontier(view)
        return int(step_towards(self._steps, *divmod(goal, view.belief.shape[1]))) if goal >= 0 else Action.STAY

    def _back_off(self, view: View) -> None:
        """Draw a retreat cell that is reachable without passing the teammate, and the steps of the retreat."""
        assert self._last is not None
        row, col = np.array(view.cell) + MOVES[self._last[1]]
        around = view.belief.copy()
        around[row, col] = np.uint8(UNKNOWN)
        reached = distances_from(around, *view.cell, self._queue, self._steps)
        self._retreat_cell = divmod(int(self._queue[self._rng.integers(reached)]), view.belief.shape[1])
        longest = min(2 ** (1 + self._retreats), sum(view.belief.shape))
        self._detour = int(self._rng.integers(1, longest + 1))

    def _towards_retreat(self, view: View) -> int:
        """Move towards the retreat cell, and wait there a little."""
        if view.cell == self._retreat_cell:
            self._detour = min(self._detour, LONGEST_WAIT)
        if self._retreat_cell is None or view.belief[self._retreat_cell] != FREE:
            return Action.STAY
        distances_from(view.belief, *view.cell, self._queue, self._steps)
        return int(step_towards(self._steps, *self._retreat_cell))


class GuardedPilot(Pilot):
    """A pilot whose moves the guard may replace."""

    kept: Explanation | None = None
    """Why the latest move was made, where anybody asks."""

    def __init__(self, briefing: Briefing, *, guard: bool) -> None:
        self._guard = Guard(briefing.shape, briefing.rng) if guard else None

    def explain(self) -> Explanation | None:
        """Return the scores of the latest moves."""
        return self.kept

    def tally(self) -> dict[str, float]:
        """Return ``guarded_share``, the share of the decisions that the guard made; nothing without a guard."""
        return {} if self._guard is None else {"guarded_share": self._guard.share}


class WatchedPilot(GuardedPilot):
    """A guarded pilot that counts the cells that its UAV discovered itself from its views."""

    def __init__(self, briefing: Briefing, *, guard: bool) -> None:
        super().__init__(briefing, guard=guard)
        self._noted = np.zeros(briefing.shape, np.uint8)
        self._lidar = lidar_model(briefing.lidar_range)
        self._scan = new_scan(self._lidar)
        self._gained = 0

    def review(self, view: View, proposal: int) -> int:
        """Return the move to make: ``proposal`` or the guard's own; stay when no frontier is reachable."""
        if self._guard is None:
            return proposal
        self._gained += int(discovered(view.belief, *view.cell, self._lidar, self._scan, self._noted))
        self._noted[...] = view.belief != UNKNOWN
        if self._guard.finished(view):
            self._guard.rest()
            return Action.STAY
        return self._guard.review(view, self._gained, proposal)
