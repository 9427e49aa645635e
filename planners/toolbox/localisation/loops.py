"""Pilots that close loops: another pilot explores, and is interrupted where the pose is probably wrong."""

from __future__ import annotations

from math import hypot
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell, Distances, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNREACHABLE, Action
from indoor_explorers.env.grid.levels import action_between
from indoor_explorers.env.policies.explanation import Explanation
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.sensing.inverse_model import HIT, PASS
from indoor_explorers.planners.toolbox.explorers import added, with_added, without_added
from indoor_explorers.planners.toolbox.localisation.trajectory import Trajectory
from indoor_explorers.planners.toolbox.navigation.paths import Paths, without

#: Numbers that are added to each message: by how many rows and columns the sender's pose is wrong, as it estimates.
ADDED = 2
#: Steps for which a place that closed no loop is not tried again.
RETRY = 30
#: Steps for which a UAV flies on where a loop closure has made its pose wrong for the second time.
FLY_ON = 20
#: Looks that it may take to put a wrong cell right: those of few are looked at first.
LOOKS = (15, 60)
#: Least variance that a flight to the surest place must save.
LEAST_SAVED = 0.02
#: Defaults of the probability of a wrong pose from which on it is taken for wrong, and of the cost of a scan, in steps.
DOUBT, SCAN_COST = 0.5, 1.0


class Closure(NamedTuple):
    """A place at which a loop can be closed."""

    place: NDArray[np.int64]
    """(2,) row and column by the UAV's own estimate."""
    steps: int
    """Steps there."""
    missed: float
    """Scans that stay in, or get to, the wrong place."""
    saved: float
    """By how much the variance of the pose is smaller there than it is now."""


class LoopPilot(Pilot):
    """Let another pilot explore, and interrupt it to close loops and to mend the map.

    Args:
        briefing: Briefing of the UAV; where nothing drifts it flies as the explorer.
        explorer: The policy that explores, and
        pilot: its pilot.
        doubt: Probability of a wrong pose from which on the UAV takes it for wrong.
        scan_cost: Cost of a scan that a correction would leave in the wrong place, in steps.

    """

    def __init__(
        self, briefing: Briefing, explorer: Policy, pilot: Pilot, doubt: float = DOUBT, scan_cost: float = SCAN_COST
    ) -> None:
        self._explorer, self._pilot, self._briefing, self._scan_cost = explorer, pilot, briefing, scan_cost
        self._rng = briefing.rng.spawn(1)[0]  # of its own, so that the explorer draws the same numbers as alone
        self._gap = briefing.scenario.drift.closure_gap
        self._paths = Paths(briefing.shape)
        self.trajectory = Trajectory(briefing, doubt)
        """The UAV's path, as it estimates it."""
        self._tried: dict[Cell, int] = {}
        self._looked_from: set[Cell] = set()
        self._went_off: set[Cell] = set()
        self._was_off = False
        self._flies_on_until = self._looks = self._blocked = self._closing = self._mending = 0
        self._last: tuple[Cell, int] | None = None
        self._interrupted, self._step = "", 0

    def act(self, view: View) -> int:
        """Explore, close a loop, or look again at what is wrong."""
        self._pilot.explaining, self._interrupted, self._step = self.explaining, "", view.step
        if view.log_odds is None or self._briefing.scenario.drift.rate == 0.0:
            return self._explore(view)
        path = self.trajectory
        path.observe(view, self._mate_error(view))
        action = self._chosen(view._replace(mates=without_added(view.mates, ADDED)))
        self.message = with_added(self._pilot.message, *path.error)
        self._was_off, self._last = path.is_off, (view.cell, action)
        path.expect(action)
        return action

    def _chosen(self, view: View) -> int:
        off = self.trajectory.is_off
        if self._is_blocked(view):
            return self._explore(view)
        if off and not self._flies_on(view) and self.is_worth_it(view):
            action = self._close_loop(view)
            if action is not None:
                return action
        shown = self._estimated(view) if off else self._warned(view)
        if self._is_explored(shown):
            shown = self._estimated(view)
        if self._is_explored(shown):
            action, shown = self._mend(view), view
            if action is not None:
                self._mending += 1
                self._interrupted = "looks again at what its map has wrong"
                return action
        return self._explore(shown)

    def explain(self) -> Explanation | None:
        """Return why the explorer was interrupted, or what it explains."""
        if not self._interrupted:
            return self._pilot.explain()
        return Explanation(step=self._step, goal=None, note=self._interrupted)

    def is_worth_it(self, view: View) -> bool:  # by the rule always
        """Tell whether to close a loop now that the pose is probably wrong."""
        return True

    def _explore(self, view: View) -> int:
        action = self._explorer.act([self._pilot], [view])[0]
        self.message, self.done = self._pilot.message, self._pilot.done
        return action

    def _is_explored(self, view: View) -> bool:
        return not self._paths.to_frontier(view.belief, view.cell, self._rng)

    def _is_blocked(self, view: View) -> bool:
        """Tell whether two moves in a row have failed: the explorer knows how to make way."""
        last = self._last
        failed = last is not None and last[1] < Action.STAY and last[0] == view.cell
        self._blocked = self._blocked + 1 if failed else 0
        return self._blocked > 1

    def _flies_on(self, view: View) -> bool:
        """Tell whether the pose became wrong where it did before: flying back would only repeat it."""
        here = self.trajectory.cell
        if not self._was_off:
            if here in self._went_off:
                self._flies_on_until = view.step + FLY_ON
            self._went_off.add(here)
        return view.step < self._flies_on_until

    # What the UAV knows by its own estimate

    def _here(self) -> Cell:
        """Return where the UAV is by its estimate, clipped to the map."""
        (row, col), (height, width) = self.trajectory.cell, self._briefing.shape
        return min(max(row, 0), height - 1), min(max(col, 0), width - 1)

    def _belief(self, view: View) -> Belief:
        """Return the (H, W) belief by the UAV's own scans at their places, and by its map where it has none."""
        own = self.trajectory.log_odds
        belief = np.where(own == 0.0, view.belief, np.where(own > 0.0, OCCUPIED, FREE)).astype(np.uint8)
        belief[self._here()] = FREE
        return belief

    def _estimated(self, view: View) -> View:
        """Return the view with the UAV's own estimates of its cell and of the map."""
        return view._replace(cell=self._here(), belief=self._belief(view))

    def _first_visits(self) -> NDArray[np.int64]:
        """Return the numbers of the scans that were the first in their place, by which loops are closed."""
        places, (height, width) = self.trajectory.places[: len(self.trajectory)], self._briefing.shape
        numbers = np.flatnonzero((places >= 0).all(axis=1) & (places < (height, width)).all(axis=1))
        return numbers[np.unique(places[numbers] @ (width, 1), return_index=True)[1]]

    def _without_traps(self, belief: Belief, here: Cell) -> Belief:
        """Return a (H, W) belief with the places closed where a loop closure would make the pose wrong."""
        path, first = self.trajectory, self._first_visits()
        first = first[path.errors[first]]
        if len(first) == 0:
            return belief
        steps = self._paths.field(belief, here)[tuple(path.places[first].T)]
        on_arrival = path.variance[len(path) - 1] + path.rate * np.where(steps < UNREACHABLE, steps, 0)
        traps = path.places[first[path.variance[first] < on_arrival]].tolist()
        return without(belief, [(row, col) for row, col in traps if (row, col) != here])

    def _warned(self, view: View) -> View:
        """Return the view without traps, if a frontier can still be reached."""
        belief = self._without_traps(view.belief, view.cell)
        warned = view._replace(belief=belief)
        return view if belief is view.belief or self._is_explored(warned) else warned

    # Closing loops

    def _close_loop(self, view: View) -> int | None:
        """Return the move towards the place where closing a loop costs least; None if there is none."""
        here, belief = self._here(), self._belief(view)
        self._tried[here] = view.step
        closure = self.cheapest_closure(view, belief)
        action = closure and self._towards(belief, here, closure.place)
        if action is not None:
            self._closing += 1
            self._interrupted = "flies to where closing a loop costs least"
        return action

    def cheapest_closure(self, view: View, belief: Belief) -> Closure | None:
        """Return where closing a loop costs least, on a (H, W) belief; None if there is no place for it."""
        path, here, now = self.trajectory, self._here(), len(self.trajectory) - 1
        first = self._first_visits()
        steps = self._paths.field(belief, here)[tuple(path.places[first].T)]
        surer = path.variance[first] < path.variance[now] + path.rate * steps - 1e-6
        tried = [self._tried.get((row, col), -RETRY) >= view.step - RETRY for row, col in path.places[first].tolist()]
        usable = (steps > 0) & (steps < UNREACHABLE) & surer & ~path.errors[first] & ~np.array(tried, np.bool_)
        if not usable.any():
            return None
        first, steps = first[usable], steps[usable]
        waiting = np.maximum(steps, self._gap - (view.step - first))
        missed = path.missed(first, steps)
        best = int(np.argmin(waiting + self._scan_cost * missed))
        scan = first[best]
        saved = path.variance[now] - path.variance[scan]
        return Closure(path.places[scan], int(steps[best]), float(missed[best]), float(saved))

    def _towards(self, belief: Belief, here: Cell, goal: NDArray[np.int64]) -> int | None:
        route = self._paths.to(belief, here, (int(goal[0]), int(goal[1])))
        return action_between(route[0], route[1]) if route and len(route) > 1 else None

    # Mending the map

    def _mend(self, view: View) -> int | None:
        """Look again at cells that the map shows wrongly, those first that take few looks; None if there are none."""
        if self.trajectory.is_off:
            return None
        for looks in LOOKS:
            wrong = self._wrong(view, looks)
            action = self._look_again(view, wrong) if wrong.any() else None
            if action is not None:
                return action
        return None

    def _wrong(self, view: View, most: int) -> Mask:
        """Return the (H, W) cells shown otherwise than the UAV's own scans say, that at most ``most`` looks correct."""
        own = self.trajectory.log_odds
        looks = np.abs(np.asarray(view.log_odds)) / np.where(own > 0.0, HIT, -PASS)
        otherwise = view.belief != np.where(own > 0.0, OCCUPIED, FREE)
        return np.asarray((own != 0.0) & otherwise & (looks <= most))

    def _look_again(self, view: View, wrong: Mask) -> int | None:
        """Stay while this step's scan corrects cells of a (H, W) mask, and else fly to the nearest place beside one."""
        here, scan = self._here(), self.trajectory.scan
        rows, cols = (scan.cells + here).T
        corrects = (scan.values > 0.0) != (view.belief[rows, cols] == OCCUPIED)
        if (wrong[rows, cols] & corrects).any() and self._looks < LOOKS[-1]:
            self._looks += 1
            return int(Action.STAY)
        self._looks = 0
        self._looked_from.add(here)
        belief = self._without_traps(self._belief(view), here)
        steps = self._paths.field(belief, here)
        beside = _with_neighbours(wrong) & (steps < UNREACHABLE) & (steps > 0)
        beside[tuple(np.array(list(self._looked_from)).T)] = False
        places = np.argwhere(beside)
        if len(places) == 0:
            return self._to_surest(belief, here, steps)
        return self._towards(belief, here, places[int(np.argmin(steps[beside]))])

    def _to_surest(self, belief: Belief, here: Cell, steps: Distances) -> int | None:
        """Fly to the surest place, from where more can be reached without traps; None if it is not much surer."""
        path, first = self.trajectory, self._first_visits()
        first = first[(steps[tuple(path.places[first].T)] < UNREACHABLE) & ~path.errors[first]]
        if len(first) == 0:
            return None
        best = first[int(np.argmin(path.variance[first]))]
        if path.variance[best] > path.variance[len(path) - 1] - LEAST_SAVED:
            return None
        self._looked_from.clear()
        return self._towards(belief, here, path.places[best])

    # Teams

    def _mate_error(self, view: View) -> Cell | None:
        """Return the error that the nearest linked teammate in sight has by its own estimate; None if there is none."""
        reach = self._briefing.lidar_range + 2
        linked = [mate for mate in view.mates if mate.age == 0 and added(mate, ADDED)]
        away = [hypot(mate.cell[0] - view.cell[0], mate.cell[1] - view.cell[1]) for mate in linked]
        if not away or min(away) > reach:
            return None
        down, right = added(linked[away.index(min(away))], ADDED)
        return int(down), int(right)

    def tally(self) -> dict[str, float]:
        """Return the explorer's figures, the slips found, and the steps flown to close loops and to mend the map."""
        own = {"slips": self.trajectory.slips, "closing": self._closing, "mending": self._mending}
        return self._pilot.tally() | {name: float(figure) for name, figure in own.items()}


def _with_neighbours(mask: Mask) -> Mask:
    """Return a (H, W) mask with the four neighbours of its cells."""
    padded = np.pad(mask, 1)
    return np.asarray(mask | padded[:-2, 1:-1] | padded[2:, 1:-1] | padded[1:-1, :-2] | padded[1:-1, 2:])
