"""Reports to a home base: explore as another policy does, and fly home, or let a teammate do it, when it is time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.explorers import ExploringWith
from indoor_explorers.planners.toolbox.parameters import bounded, one_of
from indoor_explorers.planners.toolbox.reporting import ReportingPilot

When = Literal["trips", "worth", "every", "deadline", "never"]


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
        explorer = self.make_explorer()
        return ReturnPilot(briefing, self, explorer, explorer.pilot(briefing))


class ReturnPilot(ReportingPilot):
    """Fly home by a rule."""

    def __init__(self, briefing: Briefing, policy: ReturnToBase, explorer: Policy, pilot: Pilot) -> None:
        super().__init__(briefing, explorer, pilot)
        self._policy = policy

    @property
    def reports(self) -> bool:
        """Tell whether there is a base to report to, and the rule ever does."""
        return super().reports and self._policy.when != "never"

    def is_worth_it(self, view: View) -> bool:
        """Tell whether it is time by the rule."""
        silent = view.step if view.base_age is None else view.base_age
        match self._policy.when:
            case "trips":
                return silent > self._policy.trips * 2 * self.home
            case "worth":
                return self._have_waited(view)
            case "every":
                return silent >= self._policy.every
            case _:
                return False

    def _have_waited(self, view: View) -> bool:
        """Tell whether unreported cells have waited for the cost of a flight home, and the rest leaves time for it."""
        known = self.known
        left, flight = view.belief.size - known, 2 * self.home / self.briefing.team
        if self.waited < self._policy.worth * left * flight:
            return False
        exploring = self._policy.reserve * left * view.step / known
        return self._policy.reserve == 0 or view.step + exploring + flight + self.home <= view.budget
