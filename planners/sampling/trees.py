"""Rapidly-exploring random trees, grown by OMPL from samples that the caller has drawn.

OMPL draws from one generator per process that can be seeded once. So that an episode depends on its own
seed alone, the tree is steered without it: with a goal bias of one, RRT takes every sample from its goal
region, and a region of listed states hands them out in order. No state is near enough to such a goal
to end the search, which stops after as many iterations as there are samples. What remains undetermined is
the order in which OMPL reports the vertices; they are put into an order of our own.

Every OMPL object lives inside one call. One that were still alive when the interpreter exits would make the
binding print a report about leaks.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from ompl import base, geometric, util

from indoor_explorers.env.arrays import Belief
from indoor_explorers.planners.sampling.segments import BLOCKED, fly

Points = NDArray[np.float64]


class Tree(NamedTuple):
    """A tree of K points; every parent comes before its children."""

    vertices: Points
    """(K, 2) row and column in continuous cell coordinates; the root comes first."""
    parents: NDArray[np.int64]
    """(K,) number of each vertex's parent, -1 for the root."""


class _Flights(base.MotionValidator):  # type: ignore[misc]  # ompl carries no types
    """Let OMPL ask for whole edges: exact, and one call from C++ instead of one for every state on the way."""

    def __init__(self, information: Any, belief: Belief) -> None:
        super().__init__(information)
        self._belief = belief

    def checkMotion(self, start: Any, end: Any) -> bool:  # OMPL's name
        """Tell whether the segment between two states meets no obstacle."""
        return bool(fly(self._belief, start[0], start[1], end[0], end[1]) != BLOCKED)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep OMPL from writing to the terminal."""
    level = util.getLogLevel()
    util.setLogLevel(util.LOG_NONE)
    try:
        yield
    finally:
        util.setLogLevel(level)


def grow_tree(belief: Belief, root: tuple[float, float], samples: Points, edge: float) -> Tree:
    """Grow an RRT (LaValle 1998) from ``root`` towards each of (n, 2) ``samples`` in turn.

    An edge is at most ``edge`` cells long and crosses no occupied cell of the (H, W) ``belief``; unknown is
    passable. The result depends on the arguments alone.
    """
    with _quiet():
        space = _space(belief.shape)
        information = base.SpaceInformation(space)
        information.setStateValidityChecker(_anywhere)
        information.setMotionValidator(_Flights(information, belief))
        information.setup()
        planner = geometric.RRT(information)
        planner.setGoalBias(1.0)
        planner.setRange(edge)
        planner.setProblemDefinition(_problem(space, information, root, samples))
        planner.setup()
        planner.solve(base.PlannerTerminationCondition(_after(len(samples))))
        data = base.PlannerData(information)
        planner.getPlannerData(data)
        return _ordered(*_read(data))


def _anywhere(state: Any) -> bool:
    """Accept every state: edges are what is checked."""
    return True


def _space(shape: tuple[int, ...]) -> Any:
    space = base.RealVectorStateSpace(2)
    bounds = base.RealVectorBounds(2)
    for axis, cells in enumerate(shape):
        bounds.setLow(axis, 0.0)
        bounds.setHigh(axis, float(cells))
    space.setBounds(bounds)
    return space


def _problem(space: Any, information: Any, root: tuple[float, float], samples: Points) -> Any:
    problem = base.ProblemDefinition(information)
    goal = base.GoalStates(information)
    state = space.allocState()
    state[0], state[1] = root
    problem.addStartState(state)
    for row, col in samples.tolist():
        state[0], state[1] = row, col
        goal.addState(state)
    goal.setThreshold(0.0)
    problem.setGoal(goal)
    return problem


def _after(iterations: int) -> Any:
    """Return a condition that is True from call ``iterations`` + 1 on."""
    left = iter(range(iterations))
    return lambda: next(left, None) is None


def _read(data: Any) -> tuple[list[tuple[float, float]], list[list[int]]]:
    count = data.numVertices()
    states = [data.getVertex(k).getState() for k in range(count)]
    return [(state[0], state[1]) for state in states], [list(data.getEdges(k)) for k in range(count)]


def _ordered(points: list[tuple[float, float]], children: list[list[int]]) -> Tree:
    """Put the vertices in breadth-first order from the root, siblings by their coordinates."""
    has_parent = {child for some in children for child in some}
    order = [next(k for k in range(len(points)) if k not in has_parent)]
    parents = [-1]
    for place, vertex in enumerate(order):
        below = sorted(children[vertex], key=points.__getitem__)
        order += below
        parents += [place] * len(below)
    return Tree(np.array([points[k] for k in order], np.float64).reshape(-1, 2), np.array(parents, np.int64))
