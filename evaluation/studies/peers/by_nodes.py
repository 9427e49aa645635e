"""Pilots on the graph of another simulator, by nodes: the pilot's own rule chooses among the simulator's nodes.

For policies that choose among candidates by short sequences (``frontier``, ``rrt``): their candidates are the nodes of
a tour from which all frontier points are in view that are left to see, in place of frontier clusters or viewpoints in
the grid. The gain of a node is the number of points in its view, and distances are along the graph. The rule and its
parameters are those of the policy.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.evaluation.studies.peers.graph import GraphState
from indoor_explorers.evaluation.studies.peers.tours import TourPlanner
from indoor_explorers.planners.toolbox.coordination.sequence_chooser import SequenceChooser
from indoor_explorers.planners.toolbox.routing.sequences import DecisionProblem


class Chooser(Protocol):
    """Chooses the node that the robot flies to."""

    def choose(self, state: GraphState) -> int:
        """Return a node that the robot can reach."""
        ...


class TourChoice:
    """Follow the shortest tour found: a planner for moves along a graph, and no policy of this package."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._tours = TourPlanner(rng)

    def choose(self, state: GraphState) -> int:
        """Return the first node of the tour."""
        return int(self._tours.plan(state)[0])


class NodeChoice:
    """Choose among the nodes of the shortest tour found by the rule of a pilot that has a :class:`SequenceChooser`."""

    def __init__(self, rule: SequenceChooser, lidar_range: float, rng: np.random.Generator) -> None:
        """Take the rule of a pilot; ``lidar_range`` is in metres."""
        self._rule, self._range, self._tours = rule, lidar_range, TourPlanner(rng)
        self._goal: Cell | None = None

    def choose(self, state: GraphState) -> int:
        """Return the node that the rule chooses."""
        nodes = np.sort(self._tours.plan(state))
        target = int(nodes[self._rule.first(self._problem(state, nodes), 0, np.ones(len(nodes)))])
        self._goal = state.cell(target)
        return target

    def _problem(self, state: GraphState, nodes: NDArray[np.int64]) -> DecisionProblem:
        """Return the decision problem of the rule: distances in lidar ranges, and all nodes ahead."""
        points = state.in_view[nodes].astype(np.float64)
        gains = points.sum(axis=1)
        between = state.ways(nodes)[0][:, nodes] / self._range
        kept = [state.cell(node) == self._goal for node in nodes]
        return DecisionProblem(
            cells=nodes.astype(np.int32),
            ahead=np.ones(len(nodes), np.bool_),
            away=state.away[None, nodes] / self._range,
            between=np.where(np.isfinite(between), between, UNREACHABLE),
            gains=gains,
            shared=points @ points.T / gains[:, None],
            hysteresis=1.0 + self._rule.parameters.goal_bonus * np.array(kept)[None],
        )
