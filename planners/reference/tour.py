"""The reference: a team that knows the map flies routes found by simulated annealing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.reference.plan import PlanRequest, SearchBudget, Track, plan
from indoor_explorers.planners.reference.route_pilot import RoutePilot
from indoor_explorers.planners.toolbox.parameters import Parameters, bounded


@dataclass(frozen=True, kw_only=True)
class Reference(Parameters, Policy):
    """Fly the shortest routes to 99 % coverage that a bounded search with the true map finds, and on to the goal.

    A good tour found with the map known, for comparison with policies that do not know it. It is no bound: better
    routes may exist, and policies may reach coverage below its ``aim`` sooner, since it does not plan for that. Routes
    are lists of viewpoints, changed at random by simulated annealing; every change is judged by flying it on the true
    map, sensing all along the way, the whole team at once. The search minimises the time to ``aim``, plus a
    tenth of the steps from there to the goal. Each UAV computes the same plan from the map and all starts; no messages
    are sent.

    The search is made once an episode, at its first step. Its budget counts changes and words, not seconds, so that
    every machine finds the same routes: some 0.1 s in 16x16 rooms, and one second on floors of 1,600 to 6,000 cells.

    S. Kirkpatrick, C. D. Gelatt, M. P. Vecchi, "Optimization by simulated annealing", Science 220, 1983,
    doi:10.1126/science.220.4598.671.
    """

    privileged: ClassVar[bool] = True
    plans_for: ClassVar[str] = "its aim, 99 % by default, then the scenario's goal"

    aim: float = bounded(0.99, least=1e-6, most=1)
    """Coverage that the routes reach as soon as possible: the threshold that policies are compared by; the scenario's
    goal if that is lower."""
    restarts: int = bounded(2, least=1)
    """Searches, of which the best counts."""
    changes: int = bounded(40_000, least=1)
    """Changes of the routes that each search tries."""
    work: int = bounded(100_000_000, least=1)
    """The same in words joined, 64 cells at most each: bounds the time on large maps."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return ReferencePilot(briefing, self.aim, self.budget)

    @property
    def budget(self) -> SearchBudget:
        """The effort of the search."""
        return SearchBudget(self.restarts, self.changes, self.work)


class ReferencePilot(RoutePilot):
    """Follow the UAV's own route; fly to nearest frontiers when it is complete or a teammate blocks it for too long."""

    def __init__(self, briefing: Briefing, aim: float, budget: SearchBudget) -> None:
        super().__init__(briefing)
        if briefing.truth is None or briefing.starts is None:
            raise InputError("expected a briefing with the true map and all starts, as privileged policies are given")
        self.cells, self._starts = briefing.truth, briefing.starts
        self._aim, self._budget = aim, budget

    def act(self, view: View) -> int:
        """Continue along the route."""
        if self.plans == 0:
            self.begin_route(self._planned(), view.step)
            self.plans += 1
        action = self.follow_route(view)
        return super().act(view) if action is None else action

    @property
    def request(self) -> PlanRequest:
        """The request for the plan of the team's routes."""
        briefing, scenario = self.briefing, self.briefing.scenario
        lidar, all_cells = scenario.lidar_arguments, scenario.denominator == "map"
        truth = self.cells.tobytes()
        return PlanRequest(truth, briefing.shape, self._starts, lidar, all_cells, self._aim, scenario.goal)

    def _planned(self) -> Track:
        return plan(self.request, self._budget)[self.briefing.agent]
