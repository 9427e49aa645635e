"""The oscillation guard: hands over to the nearest frontier when a learned policy goes nowhere.

A greedy network can dither between two cells for good. The guard lets it have its way while it gains new
cells itself; when the gain has stopped for longer than twice the way to the nearest frontier was then (at
least :data:`PATIENCE` steps), or the UAV swings to and fro between two cells, it flies to the nearest
frontier (Yamauchi 1997) until it gains a cell. Every such flight ends in a gain, so an episode ends. Each
handover is a strike: with every strike, the next one comes sooner and the guard then flies on for longer, so
that a network far from what it was trained on costs little more than the nearest frontier alone. Gains of
its own win the network's credit back.

A team-mate in the way is met by random back-off: draws that grow with every retreat, so that two UAVs in a
corridor do not wait for each other for ever.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import FREE, MOVES, UNKNOWN, Action
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.search.bfs import distances_from, step_towards
from indoor_explorers.env.search.frontiers import touches_unknown
from indoor_explorers.env.sensing.lidar import LidarModel, Scan, lidar_model, new_scan, visible_cells

#: Steps without a new cell that are always granted.
PATIENCE = 8
#: Strikes that still make a difference.
MOST_STRIKES = 9
#: Steps with a gain, under the policy's own control, that take a strike back.
AMENDS = 64
#: Returns in a row to the cell before the last one that are put up with.
SWINGS = 3
#: Bumps into a team-mate in a row before the UAV backs off; who flies behind one bumps now and then.
BUMPS = 2
#: Steps that a UAV waits at most where it has backed off to.
LONGEST_WAIT = 4


@kernel()
def nearest_frontier(belief: np.ndarray, row: int, col: int, queue: np.ndarray, steps: np.ndarray) -> int:
    """Return the flat index of the nearest known free cell next to an unknown one, -1 when none is in reach.

    Fills ``steps`` (H, W) int32 with the distances from (row, col); ``queue`` (H*W,) int32 is scratch.
    """
    for i in range(distances_from(belief, row, col, queue, steps)):
        r, c = divmod(queue[i], belief.shape[1])
        if touches_unknown(belief, r, c):
            return int(queue[i])
    return -1


@leaf()
def discovered(belief: np.ndarray, row: int, col: int, lidar: LidarModel, scan: Scan, noted: np.ndarray) -> int:
    """Count the known cells in view of a UAV that ``noted`` (H, W) uint8 lacks: what it has discovered itself.

    What is not in its view came by radio, and says nothing about whether it is getting anywhere.
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
        self._strikes = self._tenure = self._amends = 0
        self._swings = 0
        self._trail: tuple[Cell | None, Cell | None] = (None, None)
        self._last: tuple[Cell, int] | None = None
        self._refuge: Cell | None = None
        self._detour = 0

    @property
    def share(self) -> float:
        """Share of the decisions that were not the policy's own."""
        return self.guarded / max(self.decisions, 1)

    def review(self, view: View, gained: int, proposal: int) -> int:
        """Return the move to make: ``proposal``, or a better one; ``gained`` counts the cells it gained itself."""
        self.decisions += 1
        self._note_swings(view.cell)
        self._note_progress(view, gained)
        self._bumps = self._bumps + 1 if self._was_blocked(view) else 0
        if self._bumps >= BUMPS:
            self._retreats += 1
            self._back_off(view)
        action = self._own_move(view)
        self.guarded += action is not None
        chosen = proposal if action is None else action
        self._last = (view.cell, chosen) if view.legal[chosen] else None  # a wall is no teammate in the way
        return chosen

    def rest(self) -> None:
        """Note that the UAV stays where it is because nothing within its reach is unknown."""
        self._last = None

    def _note_swings(self, cell: Cell) -> None:
        before_last, last = self._trail
        self._swings = self._swings + 1 if cell == before_last and cell != last else 0
        self._trail = last, cell

    def _note_progress(self, view: View, gained: int) -> None:
        if gained > self._gained:
            self._gained, self._idle, self._retreats, self._detour = gained, 0, 0, 0
            self._make_amends()
            return
        self._idle += 1
        if self._idle == 1:
            goal = self._frontier(view)
            way = 2 * int(self._steps.flat[goal]) if goal >= 0 else 0
            self._limit = max(PATIENCE, way >> self._strikes)
        if self._swings > SWINGS:
            self._limit = min(self._limit, self._idle - 1)
        if self._idle == self._limit + 1 and self._tenure == 0:
            self._strikes = min(self._strikes + 1, MOST_STRIKES)
            self._tenure = 2**self._strikes - 2

    def _make_amends(self) -> None:
        """Count a gain that the policy made itself; enough of them take a strike back."""
        if self._tenure > 0:
            return
        self._amends += 1
        if self._amends >= AMENDS:
            self._strikes, self._amends = max(self._strikes - 1, 0), 0

    def _was_blocked(self, view: View) -> bool:
        return self._last is not None and self._last[1] != Action.STAY and self._last[0] == view.cell

    def _own_move(self, view: View) -> int | None:
        """Return the guard's move, None while the policy has its way."""
        if self._detour > 0:
            self._detour -= 1
            return self._towards_refuge(view)
        if self._idle > self._limit:
            return self._towards_frontier(view)
        if self._tenure > 0:
            self._tenure -= 1
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
        """Draw a place to make room at, not behind the team-mate in the way, and for how long to go there."""
        assert self._last is not None
        row, col = np.array(view.cell) + MOVES[self._last[1]]
        around = view.belief.copy()
        around[row, col] = np.uint8(UNKNOWN)
        reached = distances_from(around, *view.cell, self._queue, self._steps)
        self._refuge = divmod(int(self._queue[self._rng.integers(reached)]), view.belief.shape[1])
        longest = min(2 ** (1 + self._retreats), sum(view.belief.shape))
        self._detour = int(self._rng.integers(1, longest + 1))

    def _towards_refuge(self, view: View) -> int:
        """Move towards the refuge, and wait there a little."""
        if view.cell == self._refuge:
            self._detour = min(self._detour, LONGEST_WAIT)
        if self._refuge is None or view.belief[self._refuge] != FREE:
            return Action.STAY
        distances_from(view.belief, *view.cell, self._queue, self._steps)
        return int(step_towards(self._steps, *self._refuge))


class WatchedPilot(Pilot):
    """A pilot whose moves the guard may replace; what the UAV discovers itself is told from its views."""

    def __init__(self, briefing: Briefing, *, guard: bool) -> None:
        self._guard = Guard(briefing.shape, briefing.rng) if guard else None
        self._noted = np.zeros(briefing.shape, np.uint8)
        self._lidar = lidar_model(briefing.lidar_range)
        self._scan = new_scan(self._lidar)
        self._gained = 0

    def review(self, view: View, proposal: int) -> int:
        """Return the move to make: ``proposal``, or the guard's; to stay when that finds nothing in reach unknown."""
        if self._guard is None:
            return proposal
        self._gained += int(discovered(view.belief, *view.cell, self._lidar, self._scan, self._noted))
        self._noted[...] = view.belief != UNKNOWN
        if self._guard.finished(view):
            self._guard.rest()
            return Action.STAY
        return self._guard.review(view, self._gained, proposal)

    def tally(self) -> dict[str, float]:
        """Return ``guarded_share``, the share of the decisions that the guard took over."""
        return {} if self._guard is None else {"guarded_share": self._guard.share}
