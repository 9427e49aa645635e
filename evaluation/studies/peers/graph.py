"""The graph of viewpoints that simulators of graph-based explorers move a robot on, and what is left to see from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from indoor_explorers.env.grid.arrays import Belief, Cell, Mask


@dataclass(frozen=True, kw_only=True, eq=False)
class GraphState:
    """The state of such a simulator at a move: a robot on one of N nodes, with F frontier points left to see."""

    belief: Belief
    """(H, W) uint8, 0 unknown, 1 free, 2 occupied."""
    nodes: NDArray[np.int32]
    """(N, 2) cells (row, column)."""
    edges: NDArray[np.int32]
    """(E, 2) numbers of nodes between which the robot moves in a straight line, in both directions."""
    utility: NDArray[np.int32]
    """(N,) the simulator's own utility of the nodes: frontier points in view."""
    frontiers: NDArray[np.int32]
    """(F, 2) cells of the frontier points that the simulator counts."""
    sights: NDArray[np.int32]
    """(S, 2) a node and a frontier point in its view."""
    node: int
    """Where the robot is."""
    metres: float
    """What it has flown."""
    explored: float
    """Share of the free cells that are known."""
    done: bool
    """Whether the simulator ends here."""
    resolution: float
    """Metres a cell."""

    @classmethod
    def of(cls, answer: Mapping[str, Any], resolution: float) -> GraphState:
        """Read the answer of a simulator's script."""
        return cls(**answer, resolution=resolution)

    @cached_property
    def lengths(self) -> csr_array[np.float64]:
        """(N, N) metres of the edges."""
        ends = self.nodes[self.edges]
        metres = self.resolution * np.hypot(*(ends[:, 0] - ends[:, 1]).T)
        apart = metres > 0
        return csr_array((metres[apart], tuple(self.edges[apart].T)), shape=(len(self.nodes),) * 2)

    @cached_property
    def _from_here(self) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        away, before = self.ways(np.array([self.node]))
        return away[0], before[0]

    @property
    def away(self) -> NDArray[np.float64]:
        """(N,) metres from the robot along the edges; infinite where none lead."""
        return self._from_here[0]

    @cached_property
    def in_view(self) -> Mask:
        """(N, F) bool, which frontier points are in view of which nodes of some utility."""
        found = np.zeros((len(self.nodes), len(self.frontiers)), np.bool_)
        found[tuple(self.sights.T)] = True
        return found & (self.utility > 0)[:, None]

    @cached_property
    def useful(self) -> NDArray[np.int64]:
        """(K,) the nodes that the robot can reach and that have a utility, nearest first."""
        found = np.flatnonzero((self.utility > 0) & np.isfinite(self.away))
        found = found[found != self.node]
        return np.asarray(found[np.argsort(self.away[found], kind="stable")])

    def ways(self, nodes: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        """Return the metres from (K,) nodes to all along the edges, (K, N), and each node's predecessor, (K, N)."""
        away, before = dijkstra(self.lengths, indices=nodes, return_predecessors=True)
        return away, before

    def first_move(self, target: int) -> int:
        """Return the node after the robot's on a shortest way to another one."""
        before = self._from_here[1]
        while before[target] != self.node:
            target = int(before[target])
        return target

    def cell(self, node: int) -> Cell:
        """Return the (row, column) of a node."""
        row, col = self.nodes[node].tolist()
        return row, col
