"""Pilots that report to a home base: another pilot explores, and is interrupted when it is time to fly home."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace

from indoor_explorers.env.grid.cells import UNREACHABLE, Action
from indoor_explorers.env.policies.explanation import Explanation
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, Mate, View
from indoor_explorers.planners.toolbox.explorers import added, with_added, without_added
from indoor_explorers.planners.toolbox.navigation.navigator import Navigator
from indoor_explorers.planners.toolbox.navigation.paths import count_known

#: Numbers that are added to each message: steps home, and whether the sender flies there.
ADDED = 2
#: Reserve before the deadline: ``SPARE`` steps, and one more for every ``SPARE_EVERY`` steps of the path home.
SPARE, SPARE_EVERY = 3, 8


class ReportingPilot(Pilot):
    """Let another pilot explore, and fly home in between; subclasses tell when it is time.

    Of UAVs in contact only the one nearest to the base flies home: it has their maps, which count as reported. At the
    latest a UAV leaves when the remaining steps just suffice, or when no reachable frontier is left.

    Args:
        briefing: Briefing of the UAV; without a base it flies as the explorer.
        explorer: The policy that explores, and
        pilot: its pilot.

    """

    def __init__(self, briefing: Briefing, explorer: Policy, pilot: Pilot) -> None:
        self._explorer, self._pilot = explorer, pilot
        self.briefing = briefing
        # a generator of its own, so that the explorer draws the same numbers as alone
        self.navigator = Navigator(replace(briefing, rng=briefing.rng.spawn(1)[0]))
        """Its map, and paths on it."""
        self._rng = briefing.rng.spawn(1)[0]
        self._returning = False
        self.known = 0
        """Cells that it knows."""
        self.reported = 0
        """Cells that were known when the base, or a teammate that flies there, last had all of them."""
        self.waited = 0
        """Sum over the steps since then of the cells that were not reported."""
        self.home = int(UNREACHABLE)
        """Steps home."""
        self._explored, self._step = False, 0
        self._trips = self._handed_over = 0

    @property
    def reports(self) -> bool:
        """Tell whether there is a base to report to."""
        return self.briefing.base is not None

    @abstractmethod
    def is_worth_it(self, view: View) -> bool:
        """Tell whether it is time to fly home though there is more to explore, and time to do so."""

    def act(self, view: View) -> int:
        """Explore, or fly home."""
        self._pilot.explaining, self._step = self.explaining, view.step
        if not self.reports:
            action = self._explorer.act([self._pilot], [view])[0]
            self.message = self._pilot.message
            return action
        self._observe(view)
        self._decide(view)
        if view.base_age == 0 and self._is_late(view):
            action = int(Action.STAY)  # new cells could no longer be reported
        elif self._returning:
            action = self._fly_home(view)
        else:
            action = self._explore(view)
        own = None if self._returning else self._pilot.message
        self.message = with_added(own, self.home, self._returning)
        return action

    def _explore(self, view: View) -> int:
        """Return the explorer's action."""
        return self._explorer.act([self._pilot], [view._replace(mates=without_added(view.mates, ADDED))])[0]

    def _observe(self, view: View) -> None:
        """Update the known and reported cells, and the path home."""
        base = self.briefing.base
        assert base is not None
        self.navigator.observe(view)
        if self.navigator.map_grew:
            self.known = count_known(view.belief)
            self.steps_home = self.navigator.paths.field(view.belief, base)
            self._explored = not self.navigator.paths.to_frontier(view.belief, view.cell, self._rng)
        self.home = int(self.steps_home[view.cell])
        if view.base_age == 0:
            self._has_reported()
            self._returning = False
        self.waited += self.known - self.reported

    def _has_reported(self) -> None:
        self.reported, self.waited = self.known, 0

    def _decide(self, view: View) -> None:
        """Fly home, or leave it to a teammate, where it is time."""
        nothing_new = self.known == self.reported and not self._is_late(view)
        if view.base_age == 0 or self.home >= UNREACHABLE or nothing_new:
            self._returning = False
            return
        if self._returning or self._is_time(view):
            self._send_home(view)

    def _send_home(self, view: View) -> None:
        """Begin, or go on, to fly home, or leave it to a teammate that is nearer."""
        nearer = [mate for mate in view.mates if mate.age == 0 and home_of(mate) < (self.home, self.briefing.agent)]
        if nearer:
            self._has_reported()
            self._handed_over += 1
        elif not self._returning:
            self._trips += 1
        self._returning = not nearer

    def _is_time(self, view: View) -> bool:
        return self._explored or self._is_late(view) or self.is_worth_it(view)

    def _is_late(self, view: View) -> bool:
        """Tell whether the remaining steps just suffice for the flight home."""
        return view.budget - view.step <= self.home + SPARE + self.home // SPARE_EVERY

    def _fly_home(self, view: View) -> int:
        navigator = self.navigator
        if navigator.goal != self.briefing.base:
            navigator.set_goal(view, self.briefing.base)
        elif navigator.map_grew or navigator.is_off_path(view):
            navigator.find_path(view)
        return navigator.next_action(view)

    def explain(self) -> Explanation | None:
        """Return the way home, or what the explorer explains."""
        if not self._returning:
            return self._pilot.explain()
        path = tuple(self.navigator.path)
        return Explanation(step=self._step, goal=self.briefing.base, path=path, note="flies home to report")

    def tally(self) -> dict[str, float]:
        """Return the explorer's figures, the number of flights home, and of reports that a teammate carried."""
        return self._pilot.tally() | {"flights_home": float(self._trips), "handed_over": float(self._handed_over)}


def home_of(mate: Mate) -> tuple[float, int]:
    """Return the steps home in a teammate's message, with its number to break ties."""
    return (*added(mate, ADDED), float(UNREACHABLE))[0], mate.agent
