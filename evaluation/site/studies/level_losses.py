"""Where flights lose steps, from stored results, and a planner that knows the map some steps ahead of the frontier.

``python -P -m indoor_explorers.evaluation.site.studies.level_losses DIR`` prints the table, in Markdown. Comparisons
fly the planner as ``indoor_explorers.evaluation.site.studies.level_losses:Foresight``.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from indoor_explorers.env import Briefing, Pilot, Policy, View
from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.levels import Levels, plane_of
from indoor_explorers.env.policies.policy import ALL_CELLS
from indoor_explorers.evaluation.harness.episodes.metrics import first_step
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.planners.reference.plan import PlanRequest, SearchBudget, plan
from indoor_explorers.planners.reference.route_pilot import RoutePilot
from indoor_explorers.planners.toolbox.parameters import Parameters, bounded

#: Shares of the free cells for which steps are told; losses are counted up to the last.
SHARES = (0.5, 0.8, 0.9, 0.95, 0.99)
#: Steps in a row without a new cell that make a transit.
TRANSIT = 10


@dataclass(frozen=True, kw_only=True)
class Foresight(Parameters, Policy):
    """Fly routes annealed as those of ``reference``, on the known map and what is a few steps behind its frontier.

    A control: how far would a prediction have to reach, were it always right? One UAV; cells farther ahead are taken
    for walls.
    """

    privileged: ClassVar[bool] = True
    plans_for: ClassVar[str] = ALL_CELLS

    ahead: int = bounded(8, least=1)
    """Steps from known free cells, through free ones, up to which the map is known."""
    changes: int = bounded(4_000, least=1)
    """Changes of the route that each search tries."""
    work: int = bounded(50_000_000, least=1)
    """The same in words joined, 64 cells at most each."""
    period: int = bounded(3, least=1)
    """Steps from a plan to the next, if the map has grown."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return ForesightPilot(briefing, self)


class ForesightPilot(RoutePilot):
    """Plan a route anew when the map has grown."""

    def __init__(self, briefing: Briefing, policy: Foresight) -> None:
        super().__init__(briefing)
        if briefing.truth is None or briefing.team > 1:
            raise InputError(f"expected one UAV and the true map, got a team of {briefing.team}")
        self._truth, self._policy, self._due, self._grew = briefing.truth, policy, 0, True
        self.cells = briefing.truth

    def act(self, view: View) -> int:
        """Plan where that is due, and follow the route."""
        self.navigator.observe(view)
        self._grew |= self.navigator.map_grew
        ended = self.place + 1 >= len(self.route)
        if self._grew and (ended or view.step >= self._due):
            self._plan(view)
        action = self.follow_route(view)
        return self.proceed(view) if action is None else action

    def _plan(self, view: View) -> None:
        policy, briefing = self._policy, self.briefing
        self.cells = foreseen(self._truth, view.belief, briefing.levels, policy.ahead)
        wanted = (self.cells == FREE) & (view.belief == UNKNOWN)
        self._due, self._grew = view.step + policy.period, False
        route: tuple[Cell, ...] = ()
        if wanted.any():
            lidar, known = briefing.scenario.lidar_arguments, (~wanted).tobytes()
            task = PlanRequest(self.cells.tobytes(), briefing.shape, (view.cell,), lidar, True, 1.0, 1.0, known)
            (route,) = plan(task, SearchBudget(1, policy.changes, policy.work))
        self.begin_route(route, view.step)


def foreseen(truth: Belief, belief: Belief, levels: Levels, ahead: int) -> Belief:
    """Return a (H, W) belief whose unknown cells are free where they are within ``ahead`` steps, and else occupied."""
    free, known = levels.volume(truth) == FREE, levels.volume(belief) == FREE
    near = plane_of(ndimage.binary_dilation(known, iterations=ahead, mask=free | known), between=False)
    return np.where(belief != UNKNOWN, belief, np.where(near, FREE, OCCUPIED)).astype(np.uint8)


def losses(curve: NDArray[np.float64]) -> list[float]:
    """Return the steps to each of :data:`SHARES` from a flight's (S + 1,) coverage, and those without new cells.

    The last are all those before the last of the shares; those in transits; and those in transits from 90 % on.
    """
    reached = [first_step(curve, share) for share in SHARES]
    steps = [len(curve) if step is None else step for step in reached]
    idle = np.diff(curve[: steps[-1] + 1]) <= 0
    runs, count = ndimage.label(idle)
    transit = np.isin(runs, [k for k in range(1, count + 1) if np.count_nonzero(runs == k) >= TRANSIT])
    late = np.arange(len(idle)) >= steps[SHARES.index(0.9)]
    return [*map(float, steps), float(idle.sum()), float(transit.sum()), float((transit & late).sum())]


def table(results: Results) -> Iterator[str]:
    """Yield a row for each policy, with the means over its flights."""
    found: dict[str, list[list[float]]] = {}
    for record in results.records:
        found.setdefault(record.policy, []).append(losses(record.curve))
    for policy, rows in found.items():
        yield f"| `{policy}` | {' | '.join(f'{mean:.0f}' for mean in np.mean(rows, axis=0))} |\n"


if __name__ == "__main__":
    sys.stdout.writelines(table(Results.load(Path(sys.argv[1]))))
