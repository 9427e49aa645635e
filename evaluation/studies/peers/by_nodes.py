"""Pilots on the graph of another simulator, by nodes: the pilot's own rule chooses among the simulator's nodes.

The candidates are the nodes of a short tour from which all frontier points are in view that are left to see, in place
of frontier clusters or viewpoints in the grid; distances are along the graph. For policies that choose by short
sequences (``frontier``, ``rrt``), with the number of points in view as gain, and for those that fly to the first place
of an open tour (``frontier-tour``). The rule and its parameters are those of the policy,
but for ``switch_cost`` of ``frontier-tour``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Mask
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.evaluation.studies.peers.graph import GraphState
from indoor_explorers.evaluation.studies.peers.tours import TourPlanner
from indoor_explorers.planners.toolbox.coordination.sequence_chooser import SequenceChooser
from indoor_explorers.planners.toolbox.routing.sequences import DecisionProblem

#: Returns one of K candidates, given their decision problem and which of them is kept from the last choice, (K,) bool.
Rule = Callable[[DecisionProblem, Mask], int]


class Chooser(Protocol):
    """Chooses the node that the robot flies to."""

    def choose(self, state: GraphState) -> int:
        """Return a node that the robot can reach."""
        ...


def rule_of(pilot: Pilot) -> Rule | None:
    """Return the rule by which a pilot chooses among candidates; None if it has none of these kinds."""
    known: Any = pilot
    if isinstance(getattr(pilot, "chooser", None), SequenceChooser):
        return lambda problem, kept: _first_of_sequence(known.chooser, problem, kept)
    if hasattr(pilot, "first_of_tour"):
        return lambda problem, _: int(known.first_of_tour(_costs(problem)))
    return None


def _first_of_sequence(chooser: SequenceChooser, problem: DecisionProblem, kept: Mask) -> int:
    bonus = np.where(kept, 1.0 + chooser.parameters.goal_bonus, 1.0)
    return int(chooser.first(problem._replace(hysteresis=bonus[None]), 0, np.ones(len(kept))))


def _costs(problem: DecisionProblem) -> NDArray[np.float64]:
    """Return the distances between the robot and the candidates, (K + 1, K + 1).

    No cost of another goal is added: the nodes already come from a tour that is kept unless another one is shorter.
    """
    count = len(problem.cells)
    costs = np.zeros((1 + count, 1 + count))
    costs[0, 1:], costs[1:, 1:] = problem.away[0], problem.between
    return costs


class NodeChoice:
    """Choose among the nodes of the shortest tour found, by the rule of a pilot."""

    def __init__(self, rule: Rule, lidar_range: float, rng: np.random.Generator) -> None:
        """Take a rule; ``lidar_range`` is in metres."""
        self._rule, self._range, self._tours = rule, lidar_range, TourPlanner(rng)
        self._goal: Cell | None = None
        self._explored = -1.0

    def choose(self, state: GraphState) -> int:
        """Return the node that the rule chooses; it chooses again where the map has grown, or its node is useless."""
        grew, self._explored = state.explored > self._explored, state.explored
        goal = [node for node in state.useful.tolist() if state.cell(node) == self._goal]
        if goal and not grew:
            return int(goal[0])
        nodes = self._tours.plan(state)
        kept = np.array([state.cell(node) == self._goal for node in nodes])
        target = int(nodes[self._rule(self._problem(state, nodes), kept)])
        self._goal = state.cell(target)
        return target

    def _problem(self, state: GraphState, nodes: NDArray[np.int64]) -> DecisionProblem:
        """Return the decision problem of the rule: distances in lidar ranges, and all nodes ahead."""
        points = state.in_view[nodes].astype(np.float64)
        gains = points.sum(axis=1)
        between = state.ways(nodes)[0][:, nodes] / self._range
        return DecisionProblem(
            cells=nodes.astype(np.int32),
            ahead=np.ones(len(nodes), np.bool_),
            away=state.away[None, nodes] / self._range,
            between=np.where(np.isfinite(between), between, UNREACHABLE),
            gains=gains,
            shared=points @ points.T / gains[:, None],
            hysteresis=np.ones((1, len(nodes))),
        )
