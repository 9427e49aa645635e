"""The optimum: a team that knows the map flies routes of which a search has proved that none are shorter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import ClassVar, NamedTuple

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing
from indoor_explorers.env.search.visibility import VisibilityTable, add_visible, visibility_table
from indoor_explorers.env.sensing.lidar import lidar_model
from indoor_explorers.planners.reference.plan import PlanRequest, SearchBudget, Track, plan, swap_resolved
from indoor_explorers.planners.reference.tour import Reference, ReferencePilot
from indoor_explorers.planners.reference.watchman import EASY, Watch, fewest_steps, steps_to
from indoor_explorers.planners.toolbox.parameters import Parameters, bounded

#: Largest team and most reachable cells for which routes are searched for.
MOST_UAVS, MOST_CELLS = 2, 400
#: Searches for the routes of `reference`, from which the exact search begins: the fewer steps they take, the less there
#: is left to prove.
RESTARTS = 8
#: Most steps from the aim to the goal for which routes are searched for; nearest frontiers are flown to otherwise.
MOST_STEPS = 60


class Routes(NamedTuple):
    """Routes of a team, with bounds on the steps to the aim."""

    tracks: tuple[Track, ...]
    """The cells that each UAV flies through."""
    steps: int | None
    """Steps to the aim; None where no search was made."""
    lower: int
    """Lower bound on the steps to the aim."""
    expansions: int
    """States that the search expanded."""


@dataclass(frozen=True, kw_only=True)
class Optimum(Parameters, Policy):
    """Fly routes to 99 % coverage in the fewest steps there are, and on to the goal.

    An exact search with the true map (:mod:`indoor_explorers.planners.reference.watchman`), for one and two UAVs in
    rooms of up to 400 reachable cells. It ends where `reference`, from above, and lower bounds, from below, point to.
    Where it does not end within its effort, on larger maps and for larger teams, the routes of `reference` are flown.
    Statistics say for every episode whether the optimum is proved (``proved``, 1 or 0) and, where there was a search,
    the certified ``lower_bound`` on the steps to the aim and the effort, ``expansions``. UAVs may share a cell in the
    search, so two that meet may need more steps than the proved number.

    The effort counts expanded states, not seconds, so that every machine finds the same routes: some 0.2 s in a room of
    the thesis for one UAV, one to ten seconds for two.

    The watchman route problem on grids: S. Seiref, T. Jaffey, M. Lopatin, A. Felner, ICAPS 2020,
    doi:10.1609/icaps.v30i1.6668; S. Skyler, D. Atzmon, T. Yaffe, A. Felner, JAIR 75, 2022, doi:10.1613/jair.1.13685;
    for several UAVs S. Gouru, A. Felner, J. Li, arXiv:2604.15610. The bound and the search are this project's.
    """

    privileged: ClassVar[bool] = True
    plans_for: ClassVar[str] = Reference.plans_for

    aim: float = bounded(0.99, least=1e-6, most=1)
    """Coverage that is reached in the fewest steps; the scenario's goal if that is lower."""
    expansions: int = bounded(20_000_000, least=0)
    """Most states that the search expands; 0 for none."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return OptimumPilot(briefing, self.aim, Reference().budget, self.expansions)


class OptimumPilot(ReferencePilot):
    """Follow the UAV's own route, as :class:`ReferencePilot` does."""

    def __init__(self, briefing: Briefing, aim: float, budget: SearchBudget, expansions: int) -> None:
        super().__init__(briefing, aim, budget)
        self._expansions = expansions
        self._routes: Routes | None = None

    def _planned(self) -> Track:
        self._routes = optimal_routes(self.request, self._budget, self._expansions)
        return self._routes.tracks[self.briefing.agent]

    def tally(self) -> dict[str, float]:
        """Return whether the routes are proved optimal, the lower bound and the effort."""
        routes = self._routes
        if routes is None or routes.steps is None:
            return super().tally() | {"proved": 0.0}
        known = {"lower_bound": float(routes.lower), "expansions": float(routes.expansions)}
        return super().tally() | {"proved": float(routes.steps == routes.lower), **known}


@lru_cache(maxsize=32)
def optimal_routes(request: PlanRequest, budget: SearchBudget, expansions: int) -> Routes:
    """Return the best routes that can be found, and the bound that is proved.

    ``budget`` is that of :func:`plan`, whose routes are flown if no better ones are found. This is a pure function; its
    result is cached for the other UAVs of the team.
    """
    truth = np.frombuffer(request.truth, np.uint8).reshape(request.shape)
    table, team = _table(request, truth, request.starts), len(request.starts)
    if team > MOST_UAVS or len(table.cells) > MOST_CELLS or expansions == 0:
        return Routes(plan(request, budget), None, 0, 0)
    planned = plan(request, budget._replace(restarts=max(RESTARTS, budget.restarts)))
    total = truth.size if request.count_all_cells else len(table.cells)
    needed = math.ceil(min(request.aim, request.goal) * total - 1e-9)
    steps = steps_to(table, [_numbers(table, truth, track) for track in planned], needed)
    if steps is None:  # the coverage cannot be reached
        return Routes(planned, None, 0, 0)
    found = fewest_steps(Watch(table, team, np.zeros_like(table.union), needed), steps, expansions)
    if found.walks is None:
        return Routes(planned, steps, found.lower, found.expanded)
    walks = [[divmod(table.cells[cell].item(), truth.shape[1]) for cell in walk] for walk in found.walks]
    tracks = _as_tracks(_continued(request, truth, walks), truth.shape[1])
    return Routes(tracks, found.lower, found.lower, found.expanded)


def _table(request: PlanRequest, truth: Belief, starts: tuple[Cell, ...]) -> VisibilityTable:
    return visibility_table(truth, starts, lidar_model(*request.lidar), count_all_cells=request.count_all_cells)


def _numbers(table: VisibilityTable, truth: Belief, cells: Track | list[Cell]) -> list[int]:
    """Return the numbers of cells in a table."""
    number = {flat: k for k, flat in enumerate(table.cells.tolist())}
    return [number[row * truth.shape[1] + col] for row, col in cells]


def _continued(request: PlanRequest, truth: Belief, walks: list[list[Cell]]) -> list[list[Cell]]:
    """Return walks of a team that go on to the goal, if the way there is found at once."""
    ends = tuple(walk[-1] for walk in walks)
    if len(set(ends)) < len(ends):
        return walks
    table = _table(request, truth, ends)
    known = np.zeros_like(table.union)
    for walk in walks:
        for cell in _numbers(table, truth, walk):
            add_visible(table, cell, known)
    total = truth.size if request.count_all_cells else len(table.cells)
    watch = Watch(table, len(ends), known, math.ceil(request.goal * total - 1e-9))
    further = fewest_steps(watch, MOST_STEPS, EASY).walks
    if further is None:
        return walks
    onward = [[divmod(table.cells[cell].item(), truth.shape[1]) for cell in walk[1:]] for walk in further]
    return [walk + more for walk, more in zip(walks, onward, strict=True)]


def _as_tracks(walks: list[list[Cell]], width: int) -> tuple[Track, ...]:
    """Return tracks without consecutive repetitions, on which no two UAVs pass through each other."""
    flown = [[row * width + col for row, col in walk] for walk in walks]
    tracks = swap_resolved(flown)
    assert all(a != b for track in tracks for a, b in pairwise(track))
    return tuple(tuple(divmod(cell, width) for cell in track) for track in tracks)
