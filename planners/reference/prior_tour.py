"""A tour planned on the prior map, corrected by the known cells; frontiers where the prior is complete or wrong."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from typing import ClassVar

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN, UNREACHABLE, Action
from indoor_explorers.env.maps.walls import THICKEST
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, Mate, View
from indoor_explorers.planners.frontier.joint import FrontierJoint
from indoor_explorers.planners.reference.plan import PlanRequest, SearchBudget, Track, plan
from indoor_explorers.planners.reference.route_pilot import LOOK_AHEAD, STALLED, RoutePilot
from indoor_explorers.planners.toolbox.navigation.teammates import linked, message_of
from indoor_explorers.planners.toolbox.parameters import Parameters, bounded

#: Steps of silence after which a teammate that is heard again is planned with anew.
SILENCE = 5
#: How many times fewer changes of routes later plans try than the first.
LATER = 4
#: Steps without new cells after which frontiers are flown to until there are some: this many for each row and column.
DETOUR = 2


class Stage(IntEnum):
    """The cells that routes are planned to reveal."""

    CELLS = 0
    """The cells that can be reached, and the walls around free cells that cannot; without cells in view of the routes
    of teammates out of contact."""
    WALLS = 1
    """In addition, the other walls."""
    ALL = 2
    """All cells, whatever teammates out of contact may see."""


@dataclass(frozen=True, kw_only=True)
class PriorTour(Parameters, Policy):
    """Fly routes like those of ``reference``, planned on the prior map as far as it has proved right.

    The map planned on is the prior, with every cell that has been seen as it was seen. Linked UAVs work out the same
    routes by themselves, from the map and the cells that they share: when they meet, and when the map planned on has
    proved wrong, at once where it blocks one of their routes, else some steps after the last plan. Cells in view of the
    routes of teammates out of contact are left to them at first. A UAV whose route is complete goes on with routes that
    show the walls, behind which there may be more than the prior says, and then all that the teammates should have
    seen. `frontier` explores what is left, where a route is blocked, and while too many known cells contradict
    the prior; so every reachable cell becomes known, whatever the prior says. Without a prior this is `frontier`.

    A tour over what is known of the layout, and frontiers where that ends, are those of S. Oßwald, M. Bennewitz,
    W. Burgard, C. Stachniss, "Speeding-up robot exploration by exploiting background information", IEEE RA-L 1(2),
    2016, doi:10.1109/LRA.2016.2520560; there the layout is a graph of rooms, for one robot. The routes are annealed:
    S. Kirkpatrick et al., Science 220, 1983, doi:10.1126/science.220.4598.671.
    """

    plans_for: ClassVar[str] = "its aim, 99 % of a prior map by default, then all cells"

    aim: float = bounded(0.99, least=1e-6, most=1)
    """Coverage of the map planned on that the routes reach as soon as possible, before all of it."""
    restarts: int = bounded(2, least=1)
    """Searches of the first plan, of which the best counts; later plans make one."""
    changes: int = bounded(40_000, least=1)
    """Changes of the routes that each search tries; a quarter of it in later plans."""
    work: int = bounded(100_000_000, least=1)
    """The same in words joined, 64 cells at most each: bounds the time on large maps."""
    period: float = bounded(1.0, least=0, tunable=(0.2, 4.0, "log"))
    """Steps from a plan to the next, in lidar ranges, if known cells contradict it and no route is blocked."""
    distrust: float = bounded(0.25, least=0, tunable=(0.0, 1.0))
    """Share of the known cells that contradict the prior above which only frontiers are flown to."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        if briefing.prior is None:
            return FrontierJoint().pilot(briefing)
        return PriorTourPilot(briefing, briefing.prior, self)


class PriorTourPilot(RoutePilot):
    """Follow the UAV's own route, and let another pilot explore where there is none.

    The third number of a message is the stage of its sender's routes. A UAV in contact whose route is complete waits
    for one step, in which the others hear of the next stage, so that all plan it at the same step.
    """

    def __init__(self, briefing: Briefing, prior: Belief, policy: PriorTour) -> None:
        super().__init__(replace(briefing, rng=briefing.rng.spawn(1)[0]))
        self._explorer = FrontierJoint().pilot(briefing)
        self._prior, self._policy = prior, policy
        self._planned: Belief | None = None
        """The map of the last plan."""
        self._routes: dict[int, Track] = {}
        """The routes of the last plan by UAV; those of teammates out of contact are from the last one with them."""
        self._stage = self._next_stage = Stage.CELLS
        """The stage of the last plan, and the one that is due."""
        self._planned_at = self._grew_at = 0
        self._surprised = False
        """Whether cells were seen since the last plan that contradict it."""
        self._ages: dict[int, int] = {}
        """Steps since each teammate was last heard, as they were one step ago."""
        self._explored = 0

    def act(self, view: View) -> int:
        """Plan again where that is due, and follow the route or explore."""
        self.navigator.observe(view)
        if self.navigator.map_grew:
            self._correct_map(view)
        self._plan_if_due(view)
        action = None if self._stagnates(view) else self._fly_on(view)
        if action is None:
            self._explored += 1
            action = self._explorer.act(view)
            goal = self._explorer.message
        else:
            goal = message_of(self.route[min(self.place + LOOK_AHEAD, len(self.route) - 1)] if self.route else None)
        self.message = (*(goal or (-1.0, -1.0))[:2], float(self._next_stage))
        return action

    def _correct_map(self, view: View) -> None:
        """Correct the map by the known cells."""
        self._grew_at = view.step
        self.cells = np.where(view.belief == UNKNOWN, self._prior, view.belief)
        self._surprised = self._planned is not None and bool((self.cells != self._planned).any())

    def _plan_if_due(self, view: View) -> None:
        """Plan from the first stage if something is new, or the next one that a UAV of the group is ready for."""
        met = any(mate.age == 0 and self._ages.get(mate.agent, SILENCE) >= SILENCE for mate in view.mates)
        self._ages = {mate.agent: mate.age for mate in view.mates}
        if self._planned is None or met or self._is_wrong(view):
            self._plan(view, Stage.CELLS)
            return
        stage = max([self._next_stage, *map(_stage_of, linked(view))])
        if stage > self._stage:
            self._plan(view, stage)

    def _fly_on(self, view: View) -> int | None:
        """Return the next move of this stage's route or the following ones'; None when all are complete."""
        action = self.follow_route(view)
        while action is None and self._stage < Stage.ALL:
            silent = self._routes.keys() - self._group(view)
            self._next_stage = Stage(self._stage + 1) if silent else Stage.ALL
            if linked(view):
                return int(Action.STAY)
            self._plan(view, self._next_stage)
            action = self.follow_route(view)
        return action

    def _is_wrong(self, view: View) -> bool:
        """Tell whether the last plan has proved wrong, and must be replaced now."""
        if not self._surprised:
            return False
        due = view.step >= self._planned_at + max(1, round(self._policy.period * self.briefing.lidar_range))
        return due or any(self._is_blocked(self._routes[agent]) for agent in self._group(view) & self._routes.keys())

    def _is_blocked(self, route: Track) -> bool:
        return bool((self.cells[tuple(np.array(route).T)] == OCCUPIED).any())

    def _stagnates(self, view: View) -> bool:
        """Tell whether nothing new has been seen for so long that following routes may never end."""
        return view.step > self._grew_at + DETOUR * sum(self.briefing.shape) + STALLED

    def _group(self, view: View) -> set[int]:
        """Return the numbers of this UAV and its linked teammates."""
        return {self.briefing.agent, *(mate.agent for mate in linked(view))}

    def _plan(self, view: View, stage: Stage) -> None:
        """Plan the routes of the linked UAVs; none if too much contradicts the prior."""
        policy, known = self._policy, view.belief != UNKNOWN
        budget = SearchBudget(policy.restarts, policy.changes, policy.work)
        if self._planned is not None:
            budget = SearchBudget(1, -(-policy.changes // LATER), policy.work)
        self._planned, self._planned_at, self._surprised = self.cells, view.step, False
        self._stage = self._next_stage = stage
        places = {self.briefing.agent: view.cell} | {mate.agent: mate.cell for mate in linked(view)}
        silent = {agent: route for agent, route in self._routes.items() if agent not in places and stage < Stage.ALL}
        if np.mean(self._prior[known] != view.belief[known]) > policy.distrust:
            self._stage = self._next_stage = Stage.ALL
            self._routes = silent
            self.begin_route((), view.step)
            return
        group = sorted(places)
        others = tuple(cell for _, route in sorted(silent.items()) for cell in route)
        request = self._request(tuple(places[agent] for agent in group), stage, known, others)
        self._routes = silent | dict(zip(group, plan(request, budget), strict=True))
        self.plans += 1
        self.begin_route(self._routes[self.briefing.agent], view.step)

    def _request(self, starts: tuple[Cell, ...], stage: Stage, known: Mask, others: Track) -> PlanRequest:
        briefing, scenario = self.briefing, self.briefing.scenario
        return PlanRequest(
            truth=self.cells.tobytes(),
            shape=briefing.shape,
            starts=starts,
            lidar=scenario.lidar_arguments,
            count_all_cells=True,
            aim=self._policy.aim,
            goal=1.0,
            known=(
                known if stage > Stage.CELLS or scenario.denominator == "map" else ~self._wanted(starts, known)
            ).tobytes(),
            others=others,
        )

    def _wanted(self, starts: tuple[Cell, ...], known: Mask) -> Mask:
        """Return which unknown cells are to be seen first, (H, W) bool.

        They are free cells, and walls that may have a doorway to free cells that cannot be reached otherwise.
        """
        from scipy import ndimage  # here, since it takes long to import

        free = self.cells == FREE
        cut_off = free & (self.paths.field(self.cells, starts[0]) >= UNREACHABLE)
        doubtful = ndimage.binary_dilation(cut_off, iterations=THICKEST)
        return np.asarray((free | doubtful) & ~known)

    def tally(self) -> dict[str, float]:
        """Return the number of plans, and of steps without a route."""
        return {"plans": float(self.plans), "explored_steps": float(self._explored)}


def _stage_of(mate: Mate) -> Stage:
    """Return the stage in a teammate's message."""
    return Stage(int(mate.message[2])) if mate.message is not None and len(mate.message) > 2 else Stage.CELLS
