"""The setup of OMPL's planners: state space (R^2 or R^3), exact motion checks on a belief map, and no log output.

OMPL has one random generator per process, which can be seeded once. So that an episode depends only on its own seed,
no result of this package depends on that generator: RRT and RRT* take their samples from a goal region of listed states
(:mod:`indoor_explorers.planners.sampling.trees`), PRM* from a sampler of listed states
(:mod:`indoor_explorers.planners.sampling.roadmaps`), and all stop after a number of samples, never after a time. OMPL
still draws random numbers for its nearest-neighbour trees, whose answers do not depend on them unless two points have
the same distance to a third; therefore samples must be drawn from a continuum, not from cell centres.

Every OMPL object lives inside one call: objects that are alive when the interpreter exits make the binding print a
report about leaks.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from ompl import base, util

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.planners.sampling.points import extent
from indoor_explorers.planners.sampling.segments import ALL_KNOWN, BLOCKED, trace


class MotionChecker(base.MotionValidator):  # type: ignore[misc]  # ompl carries no types
    """Check whole edges for OMPL: exact, with one call from C++ instead of one for every state along an edge."""

    def __init__(self, information: Any, belief: Belief, rise: int, into_unknown: bool) -> None:
        super().__init__(information)
        self._belief = belief
        self._rise = rise
        self._into_unknown = into_unknown

    def checkMotion(self, start: Any, end: Any) -> bool:  # OMPL's name
        """Tell whether the segment between two states is free of obstacles, and of unknown cells if required."""
        if self._rise > 0:
            met = trace(self._belief, start[1], start[2], end[1], end[2], self._rise, start[0], end[0])
        else:
            met = trace(self._belief, start[0], start[1], end[0], end[1])
        return bool(met != BLOCKED if self._into_unknown else met == ALL_KNOWN)


@contextmanager
def silence_ompl() -> Iterator[None]:
    """Disable OMPL's output on the terminal."""
    level = util.getLogLevel()
    util.setLogLevel(util.LOG_NONE)
    try:
        yield
    finally:
        util.setLogLevel(level)


def space_of(belief: Belief, rise: int, *, into_unknown: bool) -> Any:
    """Return OMPL's space information for flights over a (H, W) belief, or its levels, not yet set up."""
    size = extent(belief.shape, rise)
    space = base.RealVectorStateSpace(len(size))
    bounds = base.RealVectorBounds(len(size))
    for axis, cells in enumerate(size):
        bounds.setLow(axis, 0.0)
        bounds.setHigh(axis, float(cells))
    space.setBounds(bounds)
    information = base.SpaceInformation(space)
    information.setStateValidityChecker(_anywhere)
    information.setMotionValidator(MotionChecker(information, belief, rise, into_unknown))
    return information


def iteration_limit(calls: int) -> Any:
    """Return a termination condition that is True from call ``calls`` + 1 on."""
    left = iter(range(calls))
    return base.PlannerTerminationCondition(lambda: next(left, None) is None)


def put(state: Any, point: Sequence[float]) -> None:
    """Write a point's coordinates (D,) into a state."""
    for axis, coordinate in enumerate(point):
        state[axis] = coordinate


def read_graph(planner: Any, information: Any) -> tuple[list[tuple[float, ...]], list[list[int]]]:
    """Return the points of a planner's graph, and for each the indices of its successors."""
    data = base.PlannerData(information)
    planner.getPlannerData(data)
    count = data.numVertices()
    states = [data.getVertex(k).getState() for k in range(count)]
    axes = range(information.getStateDimension())
    return [tuple(state[axis] for axis in axes) for state in states], [list(data.getEdges(k)) for k in range(count)]


def _anywhere(state: Any) -> bool:
    """Accept every state, as the edges are checked."""
    return True
