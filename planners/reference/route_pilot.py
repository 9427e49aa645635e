"""A pilot that follows a route, cell by cell, and makes way for teammates."""

from __future__ import annotations

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.policies.explanation import Explanation
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.frontier.nearest import NearestPilot
from indoor_explorers.planners.reference.plan import Track
from indoor_explorers.planners.toolbox.navigation.navigator import DETOUR_CELLS, DETOUR_FACTOR

#: Steps without progress, because a teammate blocks the route, after which a UAV leaves its route.
STALLED = 100
#: Number of next cells of the route that a UAV tries to reach when a teammate is in the way.
LOOK_AHEAD = 12


class RoutePilot(NearestPilot):
    """Follow routes on a map, ``cells``, that a subclass sets; without a route, fly to nearest frontiers."""

    cells: Belief
    """The map (H, W) on which routes are flown."""

    def __init__(self, briefing: Briefing) -> None:
        super().__init__(briefing)
        self.route: Track = ()
        """The cells of the route; empty when it is complete or given up."""
        self.place = 0
        """Where on it the UAV is, or was last."""
        self._moved_on = self._begun = 0

    def begin_route(self, route: Track, step: int) -> None:
        """Follow a route from its first cell, in which the UAV is."""
        self.route, self.place, self._moved_on, self._begun = route, 0, step, step
        if route:
            self.navigator.deadlock.expect(route[0], Action.STAY)  # the last move, perhaps another pilot's, is over

    def follow_route(self, view: View) -> int | None:
        """Return the next move along the route; None when it is complete or a teammate blocks it for too long."""
        self._advance(view)
        if self.place + 1 >= len(self.route) or view.step > self._moved_on + STALLED:
            self.route = ()
            return None
        if self.navigator.deadlock.should_make_way(view) and not self.navigator.deadlock.retreating:
            self._sidestep(view)
        return self.navigator.command(view, self._following(view))

    def explain(self) -> Explanation:
        """Return what is left of the route, or the nearest frontier without one."""
        if not self.route:
            return super().explain()
        left = tuple(self.route[self.place :])
        return Explanation(step=self._begun, goal=left[-1], path=left, note="a route through the map that it was shown")

    def _advance(self, view: View) -> None:
        if self.place + 1 < len(self.route) and view.cell == self.route[self.place + 1]:
            self.place += 1
            self._moved_on = view.step

    def _following(self, view: View) -> Cell:
        if self.navigator.deadlock.retreating:
            return self.navigator.deadlock.next_cell(view)
        if view.cell == self.route[self.place]:
            return self.route[self.place + 1]
        if self.navigator.is_off_path(view):
            self.navigator.follow(self._way(self.route[self.place], view) or [])
        return self.navigator.next_cell(view)

    def _way(self, goal: Cell, view: View) -> list[Cell] | None:
        """Return the shortest path on the map, around teammates if possible."""
        return self.paths.to(self.cells, view.cell, goal, self.navigator.deadlock.barred(view)) or self.paths.to(
            self.cells, view.cell, goal
        )

    def _sidestep(self, view: View) -> None:
        """Take a detour around a teammate to a later cell of the route, or retreat if that is too long."""
        for place in range(self.place + 1, min(self.place + LOOK_AHEAD, len(self.route))):
            around = self.paths.to(self.cells, view.cell, self.route[place], self.navigator.deadlock.barred(view))
            if around and len(around) - 1 <= DETOUR_FACTOR * (place - self.place) + DETOUR_CELLS:
                self.place, self._moved_on = place, view.step
                self.navigator.follow(around)
                return
        self.navigator.deadlock.retreat(view)
