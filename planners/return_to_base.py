"""Reports to a home base: explore as another policy does, and fly home, or let a teammate do it, when it is time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Literal, get_args

from indoor_explorers.env.grid.cells import UNREACHABLE, Action
from indoor_explorers.env.policies.explanation import Explanation
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.registry import make_policy
from indoor_explorers.env.policies.view import Briefing, Mate, View
from indoor_explorers.planners.toolbox.explorers import ExploringWith, added, with_added, without_added
from indoor_explorers.planners.toolbox.navigation.navigator import Navigator
from indoor_explorers.planners.toolbox.parameters import bounded, one_of

When = Literal["trips", "worth", "every", "deadline", "never"]
#: Numbers that are added to each message: steps home, and whether the sender flies there.
ADDED = 2
#: Reserve before the deadline: ``SPARE`` steps, and one more for every ``SPARE_EVERY`` steps of the path home.
SPARE, SPARE_EVERY = 3, 8


@dataclass(frozen=True, kw_only=True)
class ReturnToBase(ExploringWith):
    """Explore as another policy does, and report the map at a home base.

    Where there is no base, UAVs fly as that policy. Of UAVs in contact only the one nearest to the base flies home: it
    has their maps, which count as reported. At the latest a UAV leaves when the remaining steps
    just suffice, or when no reachable frontier is left. UAVs with the roles of explorers and relays are from
    J. de Hoog, S. Cameron, A. Visser, "Role-based autonomous multi-robot exploration", ComputationWorld 2009,
    doi:10.1109/ComputationWorld.2009.14; here the roles follow from the distances home, step by step.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    when: When = one_of("trips", get_args(When))
    """When to fly home before the end: ``trips``: when the last contact with the base is older than some flights home
    and back take; ``worth``: when what is not reported has waited so long that a flight home costs no more, and there
    is time for it; ``every``: after a fixed number of steps; ``deadline``: at the end alone; ``never``."""
    trips: float = bounded(2.0, least=0, tunable=(0.0, 8.0))
    """``trips``: how many such flights."""
    worth: float = bounded(0.5, least=0)
    """``worth``: the sum over the unreported cells of the steps that they have waited, as a share of the cost of a
    flight home: the steps by which it delays all cells that are still unknown, shared by the team. J. J. DeMatteis, "An
    economic lot-sizing technique, I: The part-period algorithm", IBM Systems Journal 7(1), 30-38, 1968."""
    reserve: float = bounded(1.0, least=0)
    """``worth``: factor on the steps that the unknown cells are expected to take at the rate so far; flights home
    before the end must leave time for them. 0: the rest need not be explored by the deadline."""
    every: int = bounded(100, least=1)
    """``every``: steps since the last contact."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        explorer = make_policy(self.explorer)
        return ReturnPilot(briefing, self, explorer, explorer.pilot(briefing))


class ReturnPilot(Pilot):
    """Let another pilot explore, and fly home in between."""

    def __init__(self, briefing: Briefing, policy: ReturnToBase, explorer: Policy, pilot: Pilot) -> None:
        self._policy, self._explorer, self._pilot = policy, explorer, pilot
        self._briefing = briefing
        # a generator of its own, so that the explorer draws the same numbers as alone
        self._navigator = Navigator(replace(briefing, rng=briefing.rng.spawn(1)[0]))
        self._rng = briefing.rng.spawn(1)[0]
        self._returning = False
        self._reported = 0
        """Cells that were known when the base, or a teammate that flies there, last had all of them."""
        self._waited = 0
        """Sum over the steps since then of the cells that were not reported."""
        self._home = int(UNREACHABLE)
        """Steps home."""
        self._explored, self._step = False, 0
        self._trips = self._handed_over = 0

    def act(self, view: View) -> int:
        """Explore, or fly home."""
        self._pilot.explaining, self._step = self.explaining, view.step
        if self._briefing.base is None or self._policy.when == "never":
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
            action = self._explorer.act([self._pilot], [view._replace(mates=without_added(view.mates, ADDED))])[0]
        own = None if self._returning else self._pilot.message
        self.message = with_added(own, self._home, self._returning)
        return action

    def _observe(self, view: View) -> None:
        """Update the known and reported cells, and the path home."""
        base = self._briefing.base
        assert base is not None
        self._navigator.observe(view)
        if self._navigator.map_grew:
            self._field = self._navigator.paths.field(view.belief, base)
            self._explored = not self._navigator.paths.to_frontier(view.belief, view.cell, self._rng)
        self._home = int(self._field[view.cell])
        if view.base_age == 0:
            self._has_reported()
            self._returning = False
        self._waited += self._navigator.known - self._reported

    def _has_reported(self) -> None:
        self._reported, self._waited = self._navigator.known, 0

    def _decide(self, view: View) -> None:
        """Begin to fly home where it is time, or leave it to a teammate that is nearer."""
        nothing_new = self._navigator.known == self._reported and not self._is_late(view)
        if view.base_age == 0 or self._home >= UNREACHABLE or nothing_new:
            self._returning = False
            return
        if not (self._returning or self._is_time(view)):
            return
        nearer = [mate for mate in view.mates if mate.age == 0 and _home_of(mate) < (self._home, self._briefing.agent)]
        if nearer:
            self._has_reported()
            self._handed_over += 1
        elif not self._returning:
            self._trips += 1
        self._returning = not nearer

    def _is_time(self, view: View) -> bool:
        silent = view.step if view.base_age is None else view.base_age
        due = {
            "trips": silent > self._policy.trips * 2 * self._home,
            "worth": self._is_worth_it(view),
            "every": silent >= self._policy.every,
        }
        return self._explored or self._is_late(view) or due.get(self._policy.when, False)

    def _is_worth_it(self, view: View) -> bool:
        """Tell whether unreported cells have waited for the cost of a flight home, and the rest leaves time for it."""
        known = self._navigator.known
        left, flight = view.belief.size - known, 2 * self._home / self._briefing.team
        if self._waited < self._policy.worth * left * flight:
            return False
        exploring = self._policy.reserve * left * view.step / known
        return self._policy.reserve == 0 or view.step + exploring + flight + self._home <= view.budget

    def _is_late(self, view: View) -> bool:
        """Tell whether the remaining steps just suffice for the flight home."""
        return view.budget - view.step <= self._home + SPARE + self._home // SPARE_EVERY

    def _fly_home(self, view: View) -> int:
        navigator = self._navigator
        if navigator.goal != self._briefing.base:
            navigator.set_goal(view, self._briefing.base)
        elif navigator.map_grew or navigator.is_off_path(view):
            navigator.find_path(view)
        return navigator.next_action(view)

    def explain(self) -> Explanation | None:
        """Return the way home, or what the explorer explains."""
        if not self._returning:
            return self._pilot.explain()
        path = tuple(self._navigator.path)
        return Explanation(step=self._step, goal=self._briefing.base, path=path, note="flies home to report")

    def tally(self) -> dict[str, float]:
        """Return the explorer's figures, the number of flights home, and of reports that a teammate carried."""
        return self._pilot.tally() | {"flights_home": float(self._trips), "handed_over": float(self._handed_over)}


def _home_of(mate: Mate) -> tuple[float, int]:
    """Return the steps home in a teammate's message, with its number to break ties."""
    return (*added(mate, ADDED), float(UNREACHABLE))[0], mate.agent
