"""Short tours along a graph of viewpoints from which all that is left to see comes in view.

Choosing viewpoints and their order together is what the expert planners of graph-based explorers do: sample covers,
order each by a travelling-salesman heuristic, and take the shortest (C. Cao et al., TARE, RSS 2021,
doi:10.15607/RSS.2021.XVII.018). Here a robot that scans at every node also sees on its way, so a viewpoint is dropped
where the ways between the others have its points in view.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.evaluation.studies.peers.graph import GraphState
from indoor_explorers.planners.toolbox.routing.open_tours import improved, open_tour

#: Covers that are sampled, besides the greedy one and the last tour's.
SAMPLES = 12
#: Distance in metres at which a node counts half as much for a cover.
HALVED = 50.0
#: Least factor on a node's points in a sampled cover.
LEAST_FACTOR = 0.3
#: Metres of a way where none leads.
NO_WAY = 1e5
#: The node before one that no way leads to.
NOWHERE = -9999

Places = NDArray[np.int64]


class TourPlanner:
    """Plan tours in one episode; what is left of the last tour is one of those compared."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng, self._last = rng, set[Cell]()

    def plan(self, state: GraphState) -> NDArray[np.int64]:
        """Return the nodes of the shortest tour found, (K,), in their order."""
        problem = _Problem(state)
        kept = [place for place, node in enumerate(problem.nodes) if place and state.cell(node) in self._last]
        factors = self._rng.uniform(LEAST_FACTOR, 1.0, (SAMPLES, len(problem.nodes)))
        covers = [problem.cover(), problem.cover(kept), *(problem.cover(factors=each) for each in factors)]
        best = min((problem.tour(cover) for cover in covers), key=problem.length)
        tour = problem.nodes[best[1:]]
        self._last = {state.cell(node) for node in tour}
        return tour


class _Problem:
    """The useful nodes of a state as places, after the robot's own, which is place 0."""

    def __init__(self, state: GraphState) -> None:
        self.nodes = np.concatenate([[state.node], state.useful])
        away, self._before = state.ways(self.nodes)
        self._away = np.nan_to_num(away[:, self.nodes], posinf=NO_WAY)
        self._in_view = state.in_view
        self._seen = state.in_view[self.nodes]
        self._seen[0] = False  # a robot sees nothing new where it is
        self._needed = self._seen.any(axis=0)

    def cover(self, chosen: Sequence[int] = (), factors: NDArray[np.float64] | None = None) -> Places:
        """Return places from which all points are in view: ``chosen``, and others greedily, near ones first."""
        found, left = list(chosen), self._needed & ~self._seen[list(chosen)].any(axis=0)
        worth = (np.ones(len(self.nodes)) if factors is None else factors) / (1.0 + self._away[0] / HALVED)
        while left.any():
            found.append(int(((self._seen & left).sum(axis=1) * worth).argmax()))
            left = left & ~self._seen[found[-1]]
        return np.array(found, np.int64)

    def tour(self, cover: Places) -> Places:
        """Return a short order of the robot's place and a cover, without places that the ways make superfluous."""
        order = self._ordered(np.concatenate([[0], cover]))
        for place in order[1:].tolist():
            others = order[order != place]
            if len(others) > 1 and self._covers(others):
                order = others
        return order[improved(self._away[np.ix_(order, order)], np.arange(len(order)))]

    def length(self, tour: Places) -> float:
        """Return the metres of a tour."""
        return float(self._away[tour[:-1], tour[1:]].sum())

    def _ordered(self, places: Places) -> Places:
        return places[open_tour(self._away[np.ix_(places, places)])]

    def _covers(self, tour: Places) -> bool:
        """Return whether all points come in view at the nodes on the ways of a tour."""
        entered = list[int]()
        for start, end in zip(tour[:-1].tolist(), tour[1:].tolist(), strict=True):
            node = int(self.nodes[end])
            while node not in (self.nodes[start], NOWHERE):
                entered.append(node)
                node = int(self._before[start, node])
        return bool((self._in_view[entered].any(axis=0) | ~self._needed).all())
