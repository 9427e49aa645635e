"""A pilot that keeps a goal and flies the shortest known path to it; planners only choose the goals."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Mask
from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.search.frontiers import on_frontier
from indoor_explorers.planners.navigation.deadlock import Yielding
from indoor_explorers.planners.navigation.paths import Paths, count_known, near_any, without
from indoor_explorers.planners.navigation.straight_paths import straight_path

#: Steps for which a goal that could not be reached is left alone.
BAN_STEPS = 50
#: A way round a teammate may be this many times as long as the straight way, and so many cells longer.
DETOUR_FACTOR, DETOUR_CELLS = 1.5, 4

_ACTIONS = {(int(row), int(col)): action for action, (row, col) in enumerate(MOVES)}


def action_between(cell: Cell, following: Cell) -> int:
    """Return the action that leads from a cell to the same or an adjacent one."""
    return _ACTIONS[following[0] - cell[0], following[1] - cell[1]]


class GoalPilot(Pilot):
    """Fly to goals that a subclass chooses.

    A goal is kept until it is no longer a frontier cell. As a UAV always sees its four neighbours, a goal
    that is reached is one no longer, and as long as a frontier cell can be reached there is a goal: so every
    reachable cell gets known. A goal that is not reached within ``max(8, 2 d)`` steps, d its distance at
    first, because teammates are in the way, is left alone for a while. A UAV that has flown to and fro twice, as when
    two keep changing their minds about each other, sticks to the goal that it has.

    ``goal`` is the present goal, and ``map_grew`` tells whether this step's map holds more than the last one's.
    """

    straight: ClassVar[bool] = False
    """Whether to fly the straightest shortest path (:mod:`~indoor_explorers.planners.navigation.straight_paths`)."""

    def __init__(self, briefing: Briefing) -> None:
        self.briefing = briefing
        self.rng = briefing.rng
        self.paths = Paths(briefing.shape)
        self.goal: Cell | None = None
        self.map_grew = False
        self._path: list[Cell] = []
        self._at = 0
        self._known = -1
        self._deadline = 0
        self._bans: dict[Cell, int] = {}
        self._lately: list[Cell] = []
        self._steady = False
        self._yielding = Yielding(self.paths, briefing.rng)
        self._guarded = 0
        self._plans = 0

    @abstractmethod
    def choose(self, view: View) -> Cell | None:
        """Return the frontier cell to fly to next, none near :meth:`avoided`; None when none is reachable."""

    def learned(self, view: View) -> None:  # a hook that most planners leave empty
        """Take note that the map has grown; called before anything is chosen."""

    def spent(self, view: View, goal: Cell) -> bool:
        """Tell whether a goal is worth flying to no longer: as a rule, when it is no frontier cell any more."""
        return not on_frontier(view.belief, goal[0] * self.paths.width + goal[1])

    def reconsider(self, view: View) -> bool:
        """Tell whether to choose again although the goal is still good; asked at every step."""
        return False

    def act(self, view: View) -> int:
        """Follow the path to the goal, choosing another goal when it is due."""
        self.look(view)
        return self.proceed(view)

    def look(self, view: View) -> None:
        """Take note of what has changed since the last step; called once a step."""
        known = count_known(view.belief)
        self.map_grew, self._known = known != self._known, known
        self._lately = [*self._lately[-3:], view.cell]
        self._steady = self._steady or self.swings

    @property
    def swings(self) -> bool:
        """Whether the UAV has just flown to and fro twice between two cells."""
        return self._lately[:2] == self._lately[2:] and len(set(self._lately)) == 2

    @property
    def stands(self) -> bool:
        """Whether the UAV has not got out of its cell in the last two steps."""
        return len(self._lately) > 2 and len(set(self._lately[-3:])) == 1

    def proceed(self, view: View) -> int:
        """Return the next move towards the goal, having looked."""
        if self.map_grew:
            self.learned(view)
        if self._goal_is_due(view):
            self._take(view, self.choose_again(view))
        elif self.map_grew or self._off_path(view):
            self._route(view)
        if self._yielding.should_make_way(view):
            self._make_way(view)
        following = self._yielding.next_cell(view) if self._yielding.retreating else self._next_cell(view)
        action = action_between(view.cell, following)
        self._yielding.expect(view.cell, action)
        return action

    def tally(self) -> dict[str, float]:
        """Return how often goals were given up because teammates kept them from being reached, and how often chosen."""
        return {"goals_given_up": float(self._guarded), "plans": float(self._plans)}

    def avoided(self, view: View) -> list[Cell]:
        """Return the goals that are left alone for now."""
        self._bans = {cell: until for cell, until in self._bans.items() if until > view.step}
        return list(self._bans)

    def shunned(self, view: View, cells: NDArray[np.int32]) -> Mask:
        """Return which of (K,) flat cells are too near to a goal that is left alone, (K,) bool."""
        return near_any(cells, self.paths.flat(self.avoided(view)), self.paths.width)

    def nearest_frontier(self, view: View) -> Cell | None:
        """Return the frontier cell with the shortest known path, drawn among equals; None when none is reachable."""
        path = self.paths.to_frontier(view.belief, view.cell, self.rng, self.avoided(view))
        return path[-1] if path else None

    def choose_again(self, view: View) -> Cell | None:
        """Choose a goal, one of those left alone when there is no other."""
        self._plans += 1
        goal = self.choose(view)
        if goal is None and self._bans:
            self._bans = {}
            goal = self.choose(view)
        return goal

    def _goal_is_due(self, view: View) -> bool:
        if self.goal is None:
            return self.map_grew
        if self.spent(view, self.goal):
            return True
        if view.step > self._deadline:
            self._guarded += 1
            self._bans[self.goal] = view.step + BAN_STEPS
            return True
        return not self._steady and self.reconsider(view)

    def _take(self, view: View, goal: Cell | None) -> None:
        kept = goal is not None and goal == self.goal
        self.goal, self._steady = goal, False
        self._route(view)
        if not kept or view.step > self._deadline:
            self._deadline = view.step + max(8, 2 * (len(self._path) - 1))

    def _route(self, view: View) -> None:
        self._path, self._at = self._shortest(view, self.goal) if self.goal else [], 0

    def _shortest(self, view: View, goal: Cell) -> list[Cell]:
        if self.straight:
            return straight_path(view.belief, view.cell, goal)
        return self.paths.to(view.belief, view.cell, goal) or []

    def _off_path(self, view: View) -> bool:
        path, at = self._path, self._at
        if at + 1 < len(path) and path[at + 1] == view.cell:
            self._at += 1
            return False
        return at >= len(path) or path[at] != view.cell

    def _next_cell(self, view: View) -> Cell:
        return self._path[self._at + 1] if self._at + 1 < len(self._path) else view.cell

    def _make_way(self, view: View) -> None:
        """Go round whoever is in the way, or to another frontier on this side, or step aside."""
        if self.goal and not self._yielding.retreating and (self._goes_round(view) or self._turns_away(view)):
            return
        self._yielding.retreat(view)

    def _goes_round(self, view: View) -> bool:
        straight = len(self._path) - self._at
        around = self.paths.to(view.belief, view.cell, self.goal, self._yielding.barred(view)) if self.goal else None
        if not around or len(around) > DETOUR_FACTOR * straight + DETOUR_CELLS:
            return False
        self._path, self._at = around, 0
        return True

    def _turns_away(self, view: View) -> bool:
        """Leave the goal alone for one on this side of whoever is in the way, at most a lidar range farther off."""
        passable = without(view.belief, self._yielding.barred(view))
        farthest = len(self._path) - self._at + self.briefing.lidar_range
        others = [*self.avoided(view), *([self.goal] if self.goal else [])]
        path = self.paths.to_frontier(passable, view.cell, self.rng, others)
        if not path or len(path) > farthest:
            return False
        self._bans.update(dict.fromkeys(others[-1:], view.step + BAN_STEPS))
        self._take(view, path[-1])
        self._path, self._at = path, 0
        return True
