"""PSO: the linked group optimises jointly who flies where."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Cell
from indoor_explorers.env.grid import UNREACHABLE
from indoor_explorers.env.policy import Pilot, Policy
from indoor_explorers.env.view import Briefing, Mate, View
from indoor_explorers.planners.clusters import frontier_clusters, nearest_cells
from indoor_explorers.planners.gains import sights
from indoor_explorers.planners.goals import GoalPilot
from indoor_explorers.planners.parameters import at_least
from indoor_explorers.planners.paths import frontier_cells, on_frontier
from indoor_explorers.planners.swarm.assignment import (
    Assignment,
    Task,
    by_hungarian,
    by_minpos,
    reachable_or_nearest,
)
from indoor_explorers.planners.swarm.particles import Swarm, optimise
from indoor_explorers.planners.teammates import linked

#: Told instead of a goal by a UAV that has none.
NOWHERE = (-1.0, -1.0)


@dataclass(frozen=True, kw_only=True)
class Pso(Policy):
    """Assign frontiers to the linked group by a particle swarm over joint assignments.

    Linked UAVs hold the same map and know each other's cells and goals, so each computes the same joint
    assignment, from a seed made of what all of them know, and flies to its own part of it. They do so together, when
    the goal of one is no frontier any more or when two meet that hold different plans; between, goals are kept.

    The swarm: J. Kennedy, R. Eberhart, ICNN 1995, doi:10.1109/ICNN.1995.488968. The fitness is this project's.
    """

    swarm: Swarm = field(default_factory=Swarm)
    """The particle swarm."""
    gain: float = 1.0
    """Weight of the union view gain, as a share of N lidar discs."""
    distance: float = 1.0
    """Weight of the mean path length, in lidar ranges."""
    crowding: float = 0.5
    """Weight of a pair of goals in the same place."""
    imbalance: float = 0.3
    """Weight of the longest path's excess over the mean, in lidar ranges."""
    hold: float = 1.0
    """A goal that a UAV already has counts as so many cells nearer."""
    candidates: int = 64
    """The most frontier clusters to choose from: the nearest to any UAV of the group."""

    def __post_init__(self) -> None:
        at_least(self, 0.0, "gain", "distance", "crowding", "imbalance", "hold")
        at_least(self, 1, "candidates")

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the mind of one UAV."""
        return PsoPilot(briefing, self)


class Member(NamedTuple):
    """One UAV of the linked group."""

    agent: int
    cell: Cell
    goal: int
    """Flat cell, -1 for none."""
    plan: tuple[float, ...]
    """The step of its last joint plan and the first agent of the group that made it."""


class PsoPilot(GoalPilot):
    """Take part in the joint plans of whoever is linked."""

    def __init__(self, briefing: Briefing, policy: Pso) -> None:
        super().__init__(briefing)
        self._policy = policy
        self._plan: tuple[float, ...] = NOWHERE
        self._weights = np.array([policy.gain, policy.distance, policy.crowding, policy.imbalance])

    def reconsider(self, view: View) -> bool:
        """Tell whether linked UAVs hold different plans or one of their goals is spent."""
        if not view.mates:
            return False
        return any(
            mate.plan != self._plan or (mate.goal >= 0 and not on_frontier(view.belief, mate.goal))
            for mate in map(self._member, linked(view))
        )

    def choose(self, view: View) -> Cell | None:
        """Return this UAV's part of the joint plan, its nearest frontier cell when there is none for it."""
        group = self.group(view)
        self._plan = (float(view.step), float(group[0].agent))
        goal = self.plan(view, group).get(self.briefing.agent)
        if goal is None or self.shunned(view, self.paths.flat([goal])).any():
            path = self.paths.to_frontier(view.belief, view.cell, self.rng, self.avoided(view))
            goal = path[-1] if path else None
        told = (float(goal[0]), float(goal[1])) if goal else NOWHERE
        self.message = told + self._plan
        return goal

    def _member(self, mate: Mate) -> Member:
        message = mate.message
        if message is None or len(message) != 4:
            return Member(mate.agent, mate.cell, -1, NOWHERE)
        goal = int(message[0]) * self.paths.width + int(message[1]) if message[0] >= 0 else -1
        return Member(mate.agent, mate.cell, goal, message[2:])

    def group(self, view: View) -> list[Member]:
        """Return the linked group, this UAV included, by number."""
        goal = self.goal[0] * self.paths.width + self.goal[1] if self.goal else -1
        own = Member(self.briefing.agent, view.cell, goal, self._plan)
        return sorted([own, *map(self._member, linked(view))])

    def plan(self, view: View, group: list[Member]) -> dict[int, Cell]:
        """Return the goal of every UAV of the group that can reach a candidate, by number.

        Every member works out the same from what all of them know.
        """
        fields = np.stack([self.paths.field(view.belief, member.cell).ravel() for member in group])
        goals = np.array([member.goal for member in group], np.int32)
        goals = np.where((goals >= 0) & frontier_cells(view.belief, np.maximum(goals, 0)), goals, -1)
        cells = self._candidate_cells(view, fields, goals)
        able = np.asarray((fields[:, cells] < UNREACHABLE).any(axis=1))
        if not able.any():
            return {}
        held = [int(np.flatnonzero(cells == goal)[0]) if goal in cells else -1 for goal in goals[able].tolist()]
        task = self._task(view, cells, fields[able], held)
        seeds = [by_hungarian(task), by_minpos(task), reachable_or_nearest(task, np.array(held, np.int64))]
        shared = np.random.default_rng([view.step, *(row * self.paths.width + col for _, (row, col), *_ in group)])
        best: Assignment = optimise(task, self._policy.swarm, seeds, shared)
        agents = [member.agent for member, can in zip(group, able.tolist(), strict=True) if can]
        return {agent: divmod(int(cells[goal]), self.paths.width) for agent, goal in zip(agents, best, strict=True)}

    def _candidate_cells(self, view: View, fields: NDArray[np.int32], goals: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return (K,) flat cells: each cluster's cell nearest to the group, and the goals that are held."""
        clusters = frontier_clusters(view.belief, self.briefing.lidar_range)
        cells, steps = nearest_cells(fields.min(axis=0).reshape(view.belief.shape), clusters)
        nearest = np.argsort(steps, kind="stable")[: self._policy.candidates]
        reached = nearest[steps[nearest] < UNREACHABLE]
        return np.union1d(cells[reached], goals[goals >= 0]).astype(np.int32)

    def _task(self, view: View, cells: NDArray[np.int32], fields: NDArray[np.int32], held: list[int]) -> Task:
        steps = fields[:, cells].astype(np.float64)
        for i, candidate in enumerate(held):
            if candidate >= 0 and steps[i, candidate] < UNREACHABLE:
                steps[i, candidate] = max(0.0, steps[i, candidate] - self._policy.hold)
        return Task(
            steps=steps,
            points=np.stack(np.divmod(cells, self.paths.width), axis=1).astype(np.float64),
            sights=sights(view.belief, cells, self.briefing.lidar_range),
            lidar_range=float(self.briefing.lidar_range),
            weights=self._weights,
        )
