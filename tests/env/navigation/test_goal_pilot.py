"""Goals: whatever a planner changes its mind to, its UAV gets somewhere."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.navigation.goal_pilot import GoalPilot
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from tests.planners.flights import fly


class Fickle(GoalPilot):
    """Prefer the frontier on the other side at every step."""

    def wants_replan(self, view: View) -> bool:
        return True

    def choose(self, view: View) -> Cell | None:
        known = np.flatnonzero(view.belief[1] == 1)
        ends = [end for end in ((1, int(known[0])), (1, int(known[-1]))) if not self.is_spent(view, end)]
        return ends[view.step % len(ends)] if ends else None


class FicklePolicy(Policy):
    def pilot(self, briefing: Briefing) -> Pilot:
        return Fickle(briefing)


def test_who_keeps_changing_its_mind_gets_somewhere() -> None:
    free = np.zeros((3, 30), np.bool_)
    free[1, 1:-1] = True
    flight = fly(FicklePolicy(), free, spawns=[(1, 15)])
    assert flight.complete
    assert 2 <= flight.longest_dither <= 6
