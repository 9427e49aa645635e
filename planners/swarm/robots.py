"""Robotic PSO: every UAV is one particle of the swarm (Couceiro, Rocha & Ferreira 2011)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp, hypot
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import MOVES, OCCUPIED, UNREACHABLE, Action
from indoor_explorers.env.policies.explanation import Explanation
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.sensing.lidar import view_gain
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters, nearest_cells
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.teammates import linked
from indoor_explorers.planners.toolbox.parameters import Parameters, bounded

#: (2,) rows and columns.
Vector = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class PsoRobots(Parameters, Policy):
    """Treat each UAV as a particle with inertia, a cognitive and a social term, and repulsion from walls and teammates.

    velocity = inertia * velocity + sum over the four terms of weight * random number * direction; the UAV makes the
    legal move closest to the velocity's direction. The cognitive term points to its own nearest frontier, the social
    one to the best frontier that the linked group has sent, by view gain e^(-d / R). Both follow shortest known paths,
    since on straight lines plain robotic PSO gets stuck in corners. A particle without new cells for some time, or one
    that oscillates, is split off from the swarm, as in the Darwinian variant: it flies to a nearest frontier and
    returns to the swarm when that is explored (``splits``, ``split_off_steps`` in the tally). So every reachable cell
    becomes known.

    The social term draws a linked group to the same place, and only repulsion within a lidar range separates it: good
    for one known destination, as the thesis says, and weak for exploration; in ``pso`` the swarm assigns goals.

    M. S. Couceiro, R. P. Rocha, N. M. F. Ferreira, "A novel multi-robot exploration approach based on particle swarm
    optimization algorithms", SSRR 2011, doi:10.1109/SSRR.2011.6106751.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    inertia: float = bounded(0.6, least=0, tunable=(0.0, 1.0))
    """Share of its velocity that a particle keeps in a step."""
    cognitive: float = bounded(1.0, least=0, tunable=(0.0, 4.0))
    """Attraction of the nearest frontier."""
    social: float = bounded(0.5, least=0, tunable=(0.0, 2.0))
    """Attraction of the best frontier sent in the linked group."""
    obstacles: float = bounded(0.2, least=0, tunable=(0.0, 2.0))
    """Repulsion of known obstacles and of the map's edge next to the UAV."""
    mates: float = bounded(0.5, least=0, tunable=(0.0, 2.0))
    """Repulsion of a linked teammate next to the UAV; it falls to 0 at a lidar range."""
    stagnation: int = bounded(30, least=1, tunable=(8, 100, "log"))
    """Steps without new cells after which a particle is split off."""
    candidates: int = bounded(16, least=1, tunable=(1, 32))
    """Number of nearest frontier clusters among which a UAV chooses its best one."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return ParticlePilot(briefing, self)


class ParticlePilot(GoalPilot):
    """Fly as a particle; when split off, to a nearest frontier."""

    def __init__(self, briefing: Briefing, policy: PsoRobots) -> None:
        super().__init__(briefing)
        self._policy = policy
        self._velocity: Vector = np.zeros(2)
        self._nearest: Cell | None = None
        self._grew_at = 0
        self._alone = False
        self._ways: dict[Cell, list[Cell]] = {}
        self._splits = self._alone_steps = 0

    def act(self, view: View) -> int:
        """Move with the swarm, or alone if split off."""
        self.navigator.observe(view)
        if self.map_grew:
            self._grew_at = view.step
        if self._alone and (self.goal is None or self.is_spent(view, self.goal)):
            self._alone = not self.map_grew
        stagnant = view.step - self._grew_at >= self._policy.stagnation
        if not self._alone and (
            stagnant or self._turned_back() or self.navigator.is_stationary
        ):  # a particle does not make way
            self._split_off(view)
        if self._alone:
            self._alone_steps += 1
            return self.proceed(view)
        if self.map_grew or self.message is None:
            self._survey(view)
        return self._drift(view)

    def choose(self, view: View) -> Cell | None:
        """Return the nearest frontier cell, for a UAV that is split off."""
        return self.nearest_frontier(view)

    def explain(self) -> Explanation:
        """Return what the swarm is drawn to, without a goal, or the frontier of a UAV that is split off."""
        told = super().explain()
        if self._alone:
            return replace(told, note="split off, to the nearest frontier")
        return replace(
            told, goal=None, path=(), note="drifts as a particle, drawn to its nearest and the best candidate"
        )

    def tally(self) -> dict[str, float]:
        """Return also how often and for how many steps the UAV was split off."""
        return {**super().tally(), "splits": float(self._splits), "split_off_steps": float(self._alone_steps)}

    def _turned_back(self) -> bool:
        """Tell whether the UAV is in the cell where it was two steps ago."""
        lately = self.navigator.recent[-3:]
        return len(lately) == 3 and lately[0] == lately[2] != lately[1]

    def _split_off(self, view: View) -> None:
        self._alone, self._velocity, self.message = True, np.zeros(2), None
        self._splits += 1
        self.choose_goal(view)

    def _survey(self, view: View) -> None:
        """Find the nearest and the best frontier, and send the best."""
        reach = self.briefing.lidar_range
        cells, steps = nearest_cells(self.steps_from(view, view.cell), frontier_clusters(view.belief, reach))
        order = np.argsort(steps, kind="stable")[: self._policy.candidates]
        near = [divmod(int(cells[k]), self.paths.width) for k in order if steps[k] < UNREACHABLE]
        worth = [
            view_gain(view.belief, cell, reach) * exp(-int(steps[k]) / reach)
            for k, cell in zip(order, near, strict=False)
        ]
        self._nearest = near[0] if near else None
        if self.explaining:
            self._chosen_at = view.step
            flat, away = self.paths.flat(near), steps[order][: len(near)]
            self.consider(flat, "view gain, less with distance; the group is drawn to its best", worth, steps=away)
        best = max(range(len(near)), key=worth.__getitem__, default=None)
        self.message = None if best is None else (float(near[best][0]), float(near[best][1]), worth[best])

    def _drift(self, view: View) -> int:
        """Update the velocity and return the legal move closest to its direction."""
        policy = self._policy
        pulls = (
            (policy.cognitive, self._towards(view, self._nearest)),
            (policy.social, self._towards(view, self._best_sent(view))),
            (policy.obstacles, self._from_walls(view)),
            (policy.mates, self._from_mates(view)),
        )
        velocity = policy.inertia * self._velocity
        for weight, direction in pulls:
            velocity = velocity + weight * self.rng.random() * direction
        self._velocity = velocity / max(1.0, hypot(*velocity))
        along = np.where(view.legal[:4], MOVES[:4] @ self._velocity, -np.inf)
        return int(along.argmax()) if view.legal[:4].any() else int(Action.STAY)

    def _best_sent(self, view: View) -> Cell | None:
        sent = [message for message in (self.message, *(mate.message for mate in linked(view))) if message]
        worth = {(int(row), int(col)): value for row, col, value in sent}
        return max((cell for cell in worth if not self.is_spent(view, cell)), key=worth.__getitem__, default=None)

    def _towards(self, view: View, goal: Cell | None) -> Vector:
        """Return the first move of a shortest known path; the path is reused while the UAV stays on it."""
        if goal is None or goal == view.cell:
            return np.zeros(2)
        way = self._ways.get(goal, [])
        if view.cell not in way:
            way = self.paths.to(view.belief, view.cell, goal) or [view.cell]
        self._ways = {**dict(list(self._ways.items())[-1:]), goal: way[way.index(view.cell) :]}
        following = self._ways[goal][1:2] or [view.cell]
        return np.subtract(following[0], view.cell).astype(np.float64)

    def _from_walls(self, view: View) -> Vector:
        away, (height, width) = np.zeros(2), view.belief.shape
        for row, col in MOVES[:4].tolist():
            r, c = view.cell[0] + row, view.cell[1] + col
            if not (0 <= r < height and 0 <= c < width) or view.belief[r, c] == OCCUPIED:
                away -= (row, col)
        return away

    def _from_mates(self, view: View) -> Vector:
        away, reach = np.zeros(2), self.briefing.lidar_range
        for mate in linked(view):
            apart = np.subtract(view.cell, mate.cell).astype(np.float64)
            distance = hypot(*apart)
            if 0 < distance < reach:
                away += apart / distance * (1 - distance / reach)
        return away
