"""Deadlock resolution: detours and retreats of a UAV when a teammate is in its way.

Teammates are not in the map, and without radio a UAV does not know of them: the only sign is a move that failed. This
also happens in a convoy, so the first failed move is ignored. From the second one on the UAV decides at random to
repeat the move or to make way: by a detour if that is not much longer, else by a retreat to a passing place (a cell
with at least three free neighbours), where it waits about as many steps as the path there had; from a crossing it
retreats in any direction. A UAV with no passing place in reach usually retries its move; the others can yield. The
longest reach of a retreat doubles each time that one soon follows another, so of two UAVs head-on in a corridor one
leaves it in the end, however long the corridor is. The reach itself is random, so that small jams are resolved nearby.
Each UAV draws from its own generator.

:mod:`indoor_explorers.learners.guard` resolves deadlocks of learned policies, which have neither goals nor paths.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.env.grid.cells import FREE, Action
from indoor_explorers.env.grid.levels import target_of
from indoor_explorers.env.policies.view import View
from indoor_explorers.planners.toolbox.navigation.paths import Paths, without

#: Consecutive failed moves before a UAV may make way.
PATIENCE = 2
#: Steps for which detours and retreats avoid a cell where a teammate was in the way.
BLOCKED_STEPS = 8
#: After this many times the reach of a retreat in steps, the next retreat starts with a short reach again.
MEMORY = 4
#: At the end of a retreat a UAV waits less than this factor times its length, and less than this number of steps.
WAIT_FACTOR, LONGEST_WAIT = 2, 6
#: Probability that a UAV without a passing place retreats anyway, and the most steps that it then waits.
BACK_OFF, SHORT_WAIT = 0.1, 4
#: Number of nearest passing places that one is drawn from; the very nearest may be the mouth of the corridor itself.
CHOICE = 12


def passing_places(belief: Belief, rise: int = 0) -> Mask:
    """Return which cells of a (H, W) belief are free and have three free neighbours or more, (H, W) bool."""
    free = np.pad(belief == FREE, 1).astype(np.int8)
    around = free[:-2, 1:-1] + free[2:, 1:-1] + free[1:-1, :-2] + free[1:-1, 2:]
    if rise > 0:
        around[rise:] += free[1 : -1 - rise, 1:-1]
        around[:-rise] += free[1 + rise : -1, 1:-1]
    return np.asarray((around >= 3) & (free[1:-1, 1:-1] > 0))


def path_to_passing_place(
    paths: Paths, belief: Belief, cell: Cell, reach: int, rng: np.random.Generator, barred: Iterable[Cell] = ()
) -> list[Cell] | None:
    """Return a path to one of the nearest passing places at most ``reach`` steps from ``cell``; None if there is none.

    ``belief`` is (H, W). The path is a list of (row, column) and avoids the cells of ``barred``.
    """
    barred = list(barred)
    steps = paths.field(without(belief, barred), cell)
    found = np.flatnonzero(passing_places(belief, paths.rise) & (steps > 0) & (steps <= reach))
    if len(found) == 0:
        return None
    nearest = found[np.argsort(steps.ravel()[found], kind="stable")[:CHOICE]]
    return paths.to(belief, cell, divmod(int(rng.choice(nearest)), paths.width), barred)


class DeadlockResolver:
    """Detect failed moves of one UAV, and make way."""

    def __init__(self, paths: Paths, rng: np.random.Generator) -> None:
        self._paths = paths
        self._rng = rng
        self._expected: Cell | None = None
        self._failures = 0
        self._blocked: dict[Cell, int] = {}
        self._reach = 1
        self._forget_at = 0
        self._retreat: list[Cell] = []
        self._wait = 0

    @property
    def retreating(self) -> bool:
        """True while the UAV is on a retreat or waits at its end."""
        return len(self._retreat) > 1 or self._wait > 0

    def expect(self, cell: Cell, action: int) -> None:
        """Store the move that is commanded in this step."""
        self._expected = None if action == Action.STAY else target_of(cell, action, self._paths.rise)

    def should_make_way(self, view: View) -> bool:
        """Tell whether moves have failed often enough and the random decision is to make way."""
        if self._expected is None or view.cell == self._expected:
            self._failures = 0
            return False
        self._failures += 1
        self._blocked[self._expected] = view.step
        return self._failures >= PATIENCE and bool(self._rng.random() < 0.5)

    def barred(self, view: View) -> list[Cell]:
        """Return the cells where teammates were in the way recently."""
        self._blocked = {
            cell: step for cell, step in self._blocked.items() if step > view.step - BLOCKED_STEPS and cell != view.cell
        }
        return list(self._blocked)

    def retreat(self, view: View) -> None:
        """Start a retreat, with a longer reach if the last one was recent."""
        if view.step >= self._forget_at:
            self._reach = 1
        self._reach = min(2 * self._reach, view.belief.size)
        self._forget_at = view.step + MEMORY * self._reach
        reach = 2 ** int(self._rng.integers(1, self._reach.bit_length()))
        barred, longest_wait = self.barred(view), 0
        path = path_to_passing_place(self._paths, view.belief, view.cell, reach, self._rng, barred)
        if path:
            longest_wait = min(WAIT_FACTOR * len(path), LONGEST_WAIT) - 1
        elif passing_places(view.belief, self._paths.rise)[view.cell] or self._rng.random() < BACK_OFF:
            path = self._paths.to_anywhere(view.belief, view.cell, reach, self._rng, barred)
            longest_wait = min(self._reach, SHORT_WAIT) if path else 0
        self._retreat = path or []
        self._wait = int(self._rng.integers(longest_wait + 1))

    def next_cell(self, view: View) -> Cell:
        """Return the next cell of the retreat; the UAV's own while it waits at its end."""
        while self._retreat and self._retreat[0] != view.cell:
            self._retreat.pop(0)
        if len(self._retreat) > 1:
            return self._retreat[1]
        self._retreat = []
        self._wait = max(0, self._wait - 1)
        return view.cell
