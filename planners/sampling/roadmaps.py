"""Probabilistic roadmaps over known free space, made by OMPL from points that the caller has drawn.

PRM* takes its milestones from the valid-state sampler of the space; a sampler of listed states returns the
points in order. Only ``growRoadmap`` is called, until it has taken every point: ``solve`` and ``constructRoadmap``
alternate, by wall time, with random bounces from old milestones, drawn from OMPL's generator, and would not be
reproducible.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from ompl import base, geometric
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.planners.sampling.points import Points, lengths
from indoor_explorers.planners.sampling.setting import put, read_graph, silence_ompl, space_of


class Roadmap(NamedTuple):
    """An undirected graph of K points."""

    points: Points
    """(K, D), in the order they were given."""
    edges: NDArray[np.int64]
    """(E, 2) numbers of the points that each edge joins, the lower one first, in lexicographic order."""

    def lengths_from(self, *sources: int) -> NDArray[np.float64]:
        """Return the lengths of the shortest paths from S points to all, (S, K) in cells, inf if there is none."""
        first, second = self.edges.T
        weights = lengths(self.points[first] - self.points[second])
        graph = csr_array((weights, (first, second)), shape=(len(self.points), len(self.points)))
        return np.asarray(dijkstra(graph, directed=False, indices=list(sources)))


class _Listed(base.ValidStateSampler):  # type: ignore[misc]  # ompl carries no types
    """Return listed points, one per call."""

    def __init__(self, information: Any, points: Iterator[list[float]]) -> None:
        super().__init__(information)
        self._points = points

    def sample(self, state: Any) -> bool:
        """Write the next point into ``state``; return whether there was one."""
        point = next(self._points, None)
        if point is not None:
            put(state, point)
        return point is not None


def grow_roadmap(belief: Belief, points: Points, rise: int = 0) -> Roadmap:
    """Connect (K, D) distinct ``points`` in known free space of a (H, W) ``belief`` to a roadmap.

    Each point is connected to its nearest ones by every segment that stays in known free cells: to as many as make
    paths asymptotically optimal (PRM*, Karaman & Frazzoli 2011). The result depends only on the arguments.
    """
    with silence_ompl():
        information = space_of(belief, rise, into_unknown=False)
        information.setValidStateSamplerAllocator(lambda owner: _Listed(owner, iter(points.tolist())))
        information.setup()
        planner = geometric.PRMstar(information)
        planner.setProblemDefinition(base.ProblemDefinition(information))
        planner.setup()
        planner.growRoadmapPtc(base.PlannerTerminationCondition(lambda: planner.milestoneCount() >= len(points)))
        found, joined = read_graph(planner, information)
        information.clearValidStateSamplerAllocator()
    number = {tuple(point): k for k, point in enumerate(points.tolist())}
    return Roadmap(points, _pairs([number[point] for point in found], joined))


def _pairs(numbers: list[int], joined: list[list[int]]) -> NDArray[np.int64]:
    """Return the pairs of ``numbers`` whose places are joined, (E, 2), each once, in lexicographic order."""
    ends = np.array(numbers, np.int64)
    firsts = np.repeat(ends, [len(others) for others in joined])
    seconds = ends[[other for others in joined for other in others]]
    span = ends.max(initial=0) + 1
    pairs = np.unique(np.minimum(firsts, seconds) * span + np.maximum(firsts, seconds))
    return np.stack(np.divmod(pairs, span), axis=1)
