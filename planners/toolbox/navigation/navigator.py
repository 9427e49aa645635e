"""Navigation to a goal: follow a shortest known path, give way, and give up goals that cannot be reached."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell, Distances, Mask
from indoor_explorers.env.grid.levels import action_between
from indoor_explorers.env.policies.renamed import renamed_property
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.navigation.camera_moves import CameraMoves
from indoor_explorers.planners.toolbox.navigation.deadlock import DeadlockResolver
from indoor_explorers.planners.toolbox.navigation.paths import Paths, map_stamp, near_any, without
from indoor_explorers.planners.toolbox.navigation.straight_paths import straight_path

#: Steps for which a goal that could not be reached is banned.
BAN_STEPS = 50
#: Longest detour around a teammate: this factor times the length of the path that it replaces, plus this many cells.
#: Once every goal was banned, as behind a teammate that has stopped, any length is taken until the map grows.
DETOUR_FACTOR, DETOUR_CELLS = 1.5, 4


class Navigator:
    """Keep the goal of one UAV, the path to it and the banned goals, and resolve deadlocks.

    A goal that is not reached within ``max(8, 2 d)`` steps, d its initial distance, because teammates are in the way,
    is banned for ``BAN_STEPS`` steps. Call :meth:`observe` once per step, before any other method.

    Args:
        briefing: Briefing of the UAV.
        straight: Whether to fly the straightest shortest path
            (:mod:`~indoor_explorers.planners.toolbox.navigation.straight_paths`).
        rise: That of the map where the UAV changes levels (:mod:`indoor_explorers.env.grid.levels`), 0 where it does
            not.

    """

    def __init__(self, briefing: Briefing, *, straight: bool = False, rise: int = 0) -> None:
        self.paths = Paths(briefing.shape, rise)
        self.deadlock = DeadlockResolver(self.paths, briefing.rng)
        self.goal: Cell | None = None
        self.map_grew = False
        """Whether the map has changed since the last step: cells have become known, or are known better."""
        self.stamp = -1
        """The :func:`~.paths.map_stamp` of the map: an equal number means an unchanged map."""
        self.camera: CameraMoves | None = None
        """The choice among shortest paths by what a limited field of view shows on them, if any."""
        self.recent: list[Cell] = []
        """The cells of the last four steps, the current one last."""
        self.given_up = 0
        """Number of goals given up because they were not reached in time."""
        self._rng, self._lidar_range, self._straight = briefing.rng, briefing.lidar_range, straight
        self._path: list[Cell] = []
        self._at = 0
        self._deadline = 0
        self._bans: dict[Cell, int] = {}
        self._all_banned = False
        """Whether every goal was banned since the map has last grown."""
        self._settled = False
        self._own_field: tuple[int, Cell, Distances] | None = None

    @property
    def oscillates(self) -> bool:
        """Whether the UAV has just oscillated between two cells twice."""
        return self.recent[:2] == self.recent[2:] and len(set(self.recent)) == 2

    @property
    def is_stationary(self) -> bool:
        """Whether the UAV has not left its cell in the last two steps."""
        return len(self.recent) > 2 and len(set(self.recent[-3:])) == 1

    swings = renamed_property("Navigator.swings", "oscillates")
    stands = renamed_property("Navigator.stands", "is_stationary")

    @property
    def may_replan(self) -> bool:
        """Whether a useful goal may be replaced: not after an oscillation, until the next goal is set."""
        return not self._settled

    @property
    def path(self) -> list[Cell]:
        """The cells that are left of the path to the goal, from the UAV's on; empty without a goal."""
        return self._path[self._at :]

    def observe(self, view: View) -> None:
        """Update the state from this step's view."""
        stamp = map_stamp(view)
        self.map_grew, self.stamp = stamp != self.stamp, stamp
        self.recent = [*self.recent[-3:], view.cell]
        self._settled = self._settled or self.oscillates
        self._all_banned = self._all_banned and not self.map_grew
        self._own_field = None

    def steps_from(self, view: View, cell: Cell) -> Distances:
        """Return the (H, W) steps from a cell through known free cells; those from the UAV's cell are cached."""
        if cell != view.cell:
            return self.paths.field(view.belief, cell)
        if self._own_field is None or self._own_field[:2] != (view.step, cell):
            self._own_field = view.step, cell, self.paths.field(view.belief, cell)
        return self._own_field[2]

    def set_goal(self, view: View, goal: Cell | None) -> None:
        """Set the goal; None to stay."""
        kept = goal is not None and goal == self.goal
        self.goal, self._settled = goal, False
        self.find_path(view)
        if not kept or view.step > self._deadline:
            self._deadline = view.step + max(8, 2 * (len(self._path) - 1))

    def is_overdue(self, view: View) -> bool:
        """Tell whether the time for reaching the goal is over; the goal is then banned."""
        if self.goal is None or view.step <= self._deadline:
            return False
        self.given_up += 1
        self._bans[self.goal] = view.step + BAN_STEPS
        return True

    def banned(self, view: View) -> list[Cell]:
        """Return the currently banned goals."""
        self._bans = {cell: until for cell, until in self._bans.items() if until > view.step}
        return list(self._bans)

    def lift_bans(self) -> bool:
        """Remove all bans; return whether there were any."""
        self._all_banned, self._bans = bool(self._bans), {}
        return self._all_banned

    def near_banned(self, view: View, cells: NDArray[np.int32]) -> Mask:
        """Return which of (K,) flat cells are too close to a banned goal, (K,) bool.

        Once every goal was banned, only the goals themselves are, as the last unknown cells may be beside one of them.
        """
        banned, paths = self.paths.flat(self.banned(view)), self.paths
        return np.isin(cells, banned) if self._all_banned else near_any(cells, banned, paths.width, paths.rise)

    def nearest_frontier(self, view: View) -> Cell | None:
        """Return the frontier cell with the shortest known path, drawn at random among equals; None if unreachable."""
        path = self._to_frontier(view, view.belief, self.banned(view))
        return path[-1] if path else None

    def _to_frontier(self, view: View, passable: Belief, banned: list[Cell]) -> list[Cell] | None:
        """Return a shortest path on a (H, W) belief to a frontier cell that is not too close to a banned goal."""
        if self._all_banned:
            passable, banned = without(passable, banned), []
        return self.paths.to_frontier(passable, view.cell, self._rng, banned)

    def find_path(self, view: View) -> None:
        """Plan a new path to the goal."""
        self.follow(self._shortest(view, self.goal) if self.goal else [])

    def follow(self, path: list[Cell]) -> None:
        """Set the path, which begins at the UAV's cell."""
        self._path, self._at = path, 0

    def is_off_path(self, view: View) -> bool:
        """Advance along the path to the UAV's cell; tell whether the UAV is not on it."""
        path, at = self._path, self._at
        if at + 1 < len(path) and path[at + 1] == view.cell:
            self._at += 1
            return False
        return at >= len(path) or path[at] != view.cell

    def next_cell(self, view: View) -> Cell:
        """Return the next cell of the path; the UAV's own at its end."""
        left = self.path
        if len(left) < 2:
            return view.cell
        return left[1] if self.camera is None else self.camera.next_cell(view, left, self.stamp)

    def next_action(self, view: View) -> int:
        """Return the next move along the path, or along a retreat from a teammate in the way."""
        if self.deadlock.should_make_way(view):
            self._make_way(view)
        following = self.deadlock.next_cell(view) if self.deadlock.retreating else self.next_cell(view)
        return self.command(view, following)

    def command(self, view: View, following: Cell) -> int:
        """Return the action that leads to an adjacent cell, and store the move to detect its failure."""
        action = action_between(view.cell, following, self.paths.rise)
        self.deadlock.expect(view.cell, action)
        return action

    def _shortest(self, view: View, goal: Cell) -> list[Cell]:
        if self._straight:
            return straight_path(view.belief, view.cell, goal, self.paths.rise)
        return self.paths.to(view.belief, view.cell, goal) or []

    def _make_way(self, view: View) -> None:
        """Make way: take a detour around the teammate, or another frontier on this side of it, or retreat."""
        if self.goal and not self.deadlock.retreating and (self._goes_round(view) or self._turns_away(view)):
            return
        self.deadlock.retreat(view)

    def _goes_round(self, view: View) -> bool:
        left = len(self._path) - self._at
        around = self.paths.to(view.belief, view.cell, self.goal, self.deadlock.barred(view)) if self.goal else None
        if not around or (not self._all_banned and len(around) > DETOUR_FACTOR * left + DETOUR_CELLS):
            return False
        if self._all_banned:
            self._deadline = view.step + 2 * len(around)
        self.follow(around)
        return True

    def _turns_away(self, view: View) -> bool:
        """Ban the goal and choose a frontier on this side of the teammate, at most a lidar range farther away."""
        passable = without(view.belief, self.deadlock.barred(view))
        farthest = len(self._path) - self._at + self._lidar_range
        others = [*self.banned(view), *([self.goal] if self.goal else [])]
        path = self._to_frontier(view, passable, others)
        if not path or len(path) > farthest:
            return False
        self._bans.update(dict.fromkeys(others[-1:], view.step + BAN_STEPS))
        self.set_goal(view, path[-1])
        self.follow(path)
        return True
