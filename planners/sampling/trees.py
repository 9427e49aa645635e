"""Rapidly-exploring random trees, grown by OMPL from samples that the caller has drawn.

With a goal bias of one, RRT and RRT* take every sample from their goal region; a region of listed states returns them
in order. No state is close enough to such a goal to end the search, which stops after as many iterations as there are
samples. Only the order in which OMPL reports the vertices is undetermined, so they are sorted.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from ompl import base, geometric

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.planners.sampling.points import Points, lengths
from indoor_explorers.planners.sampling.setting import iteration_limit, put, read_graph, silence_ompl, space_of


class Tree(NamedTuple):
    """A tree of K points; every parent comes before its children."""

    vertices: Points
    """(K, D) points; the root comes first."""
    parents: NDArray[np.int64]
    """(K,) number of each vertex's parent, -1 for the root."""

    def lengths(self) -> NDArray[np.float64]:
        """Return the path length from the root to each vertex along the tree, (K,) in cells."""
        edges = lengths(self.vertices - self.vertices[np.maximum(self.parents, 0)])
        totals = np.zeros(len(edges))
        for vertex, parent in enumerate(self.parents.tolist()[1:], start=1):
            totals[vertex] = totals[parent] + edges[vertex]
        return totals


def grow_tree(
    belief: Belief,
    root: tuple[float, ...],
    samples: Points,
    edge: float,
    rise: int = 0,
    *,
    optimal: bool = False,
    into_unknown: bool = True,
) -> Tree:
    """Grow an RRT (LaValle 1998) from ``root`` towards each of (n, D) ``samples`` in turn.

    An edge is at most ``edge`` cells long and crosses no occupied cell of the (H, W) ``belief``, and no unknown one
    unless ``into_unknown``. ``optimal`` makes it an RRT* (Karaman & Frazzoli 2011), whose paths from the root get
    shorter with more samples. The result depends only on the arguments.
    """
    with silence_ompl():
        information = space_of(belief, rise, into_unknown=into_unknown)
        information.setup()
        planner = geometric.RRTstar(information) if optimal else geometric.RRT(information)
        planner.setGoalBias(1.0)
        planner.setRange(edge)
        planner.setProblemDefinition(_problem(information, root, samples))
        planner.setup()
        planner.solve(iteration_limit(len(samples)))
        return _ordered(*read_graph(planner, information))


def _problem(information: Any, root: tuple[float, ...], samples: Points) -> Any:
    problem = base.ProblemDefinition(information)
    goal = base.GoalStates(information)
    state = information.allocState()
    put(state, root)
    problem.addStartState(state)
    for point in samples.tolist():
        put(state, point)
        goal.addState(state)
    goal.setThreshold(0.0)
    problem.setGoal(goal)
    return problem


def _ordered(points: list[tuple[float, ...]], children: list[list[int]]) -> Tree:
    """Put the vertices in breadth-first order from the root, siblings by their coordinates."""
    has_parent = {child for some in children for child in some}
    order = [next(k for k in range(len(points)) if k not in has_parent)]
    parents = [-1]
    for place, vertex in enumerate(order):
        below = sorted(children[vertex], key=points.__getitem__)
        order += below
        parents += [place] * len(below)
    return Tree(np.array([points[k] for k in order], np.float64), np.array(parents, np.int64))
