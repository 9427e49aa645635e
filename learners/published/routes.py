"""The sparse global graph of IR2: places that the team has been to, and branches towards frontiers.

Its nodes are joined by clear lines of at most two lidar ranges, and nodes close together are merged away from frontiers
where that leaves the graph connected. The published code renews the edges of a node when nodes near it change; here all
edges are those of the current map.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.learners.published import lattice
from indoor_explorers.learners.published.lattice import Indices, Points

NEIGHBOURS = 30
#: Pixels: the longest edge; how far branches reach, and how far their ends are from all other nodes.
LONGEST, BRANCH, APART = 160.0, 80.0, 40.0
#: Nodes that the branches of one choice add at least, before no more are begun.
BRANCHES = 6
#: Pixels within which nodes are merged; frontiers protect those within the second length.
MERGED, PROTECTED = 30.0, 120.0
#: Choices between two mergers, and nodes above which every choice merges.
PERIOD, MOST = 10, 340


class GlobalGraph:
    """The global graph of one UAV in one episode; ``pixel`` is the number of cells of a pixel."""

    def __init__(self, shape: tuple[int, int], pixel: float) -> None:
        self._width, self._pixel = shape[1], pixel
        self.cells: Points = np.empty((0, 2), np.int64)
        """(M, 2) rows and columns."""

    def add(self, cells: Sequence[Cell]) -> None:
        """Add nodes, those that are none yet."""
        there = set(map(tuple, self.cells.tolist()))
        fresh = [cell for cell in dict.fromkeys(cells) if cell not in there]
        self.cells = np.concatenate([self.cells, np.array(fresh, np.int64).reshape(-1, 2)])

    def branch_off(self, belief: Belief, cell: Cell, nodes: Points, utility: NDArray[np.float64]) -> None:
        """Add the nodes of highest utility around the UAV, apart from each other, with the way to each out of sight."""
        if not len(self.cells):
            return
        own, graph = int(np.square(nodes - cell).sum(axis=1).argmin()), None
        added: list[int] = []
        close = np.hypot(*(nodes - cell).T) <= BRANCH * self._pixel
        for node in np.argsort(-utility, kind="stable"):
            if len(added) >= BRANCHES or utility[node] == 0:
                break
            there = np.concatenate([self.cells, nodes[added]]) - nodes[node]
            if not close[node] or (np.hypot(*there.T) < APART * self._pixel).any():
                continue
            if lattice.clear_lines(belief, nodes[own : own + 1], nodes[node : node + 1])[0]:
                added.append(int(node))
                continue
            graph = graph or lattice.walks(
                nodes, lattice.straight_edges(belief, nodes, lattice.nearest(nodes, nodes, NEIGHBOURS)), own
            )
            added += lattice.walk_to(graph[1], int(node)) if np.isfinite(graph[0][node]) else []
        self.add([divmod(flat, self._width) for flat in (nodes[added] @ (self._width, 1)).tolist()])

    def thin(self, belief: Belief, choices: int, uavs: list[Cell]) -> None:
        """Merge nodes, at every tenth choice or when there are many."""
        if not len(self.cells) or (choices % PERIOD and len(self.cells) <= MOST):
            return
        done, kept = self._protected(belief, uavs), np.ones(len(self.cells), np.bool_)
        parts = self._parts(belief, kept)
        for node in range(len(self.cells)):
            close = np.hypot(*(self.cells - self.cells[node]).T) < MERGED * self._pixel
            merged = close & kept & ~done & (np.arange(len(close)) != node)
            if not done[node] and merged.any() and self._parts(belief, kept & ~merged) <= parts:
                kept &= ~merged
                done |= merged
                done[node] = True
        self.cells = self.cells[kept]

    def long_edges(self, belief: Belief, nodes: Points, least: float, most: int) -> Indices:
        """Return the edges longer than ``least`` pixels from each of (N, 2) nodes, (N, most), -1 for none."""
        out = np.full((len(nodes), most), -1, np.int64)
        pairs, length = self._edges(belief, self.cells)
        flat = nodes @ (self._width, 1)
        order = np.argsort(flat)
        number = order[np.searchsorted(flat, self.cells @ (self._width, 1), sorter=order)]  # all of these are nodes
        pairs = pairs[length > least * self._pixel]
        place = np.arange(len(pairs)) - np.searchsorted(pairs[:, 0], pairs[:, 0])
        near, place = number[pairs[place < most]], place[place < most]
        out[near[:, 0], place] = near[:, 1]
        return out

    def _edges(self, belief: Belief, cells: Points) -> tuple[Indices, NDArray[np.float64]]:
        """Return the pairs (P, 2) of (M, 2) cells that are joined, either way, nearest first, and lengths (P,)."""
        if not len(cells):
            return np.empty((0, 2), np.int64), np.empty(0)
        pairs = lattice.pairs_of(lattice.nearest(cells, cells, NEIGHBOURS))
        pairs = pairs[np.hypot(*(cells[pairs[:, 0]] - cells[pairs[:, 1]]).T) <= LONGEST * self._pixel]
        pairs = pairs[lattice.clear_lines(belief, cells[pairs[:, 0]], cells[pairs[:, 1]])]
        pairs = np.unique(np.concatenate([pairs, pairs[:, ::-1]]), axis=0)
        length = np.hypot(*(cells[pairs[:, 0]] - cells[pairs[:, 1]]).T)
        order = np.lexsort((length, pairs[:, 0]))
        return pairs[order], length[order]

    def _protected(self, belief: Belief, uavs: list[Cell]) -> Mask:
        """Return which nodes are near a frontier or a UAV, (M,) bool."""
        points = np.concatenate([lattice.frontier_points(belief, 1), np.array(uavs)])
        reach = np.where(np.arange(len(points)) < len(points) - len(uavs), PROTECTED, MERGED) * self._pixel
        away = np.hypot(*(self.cells[:, None] - points[None]).transpose(2, 0, 1))
        return np.asarray((away < reach).any(axis=1))

    def _parts(self, belief: Belief, kept: Mask) -> int:
        """Return how many connected parts the graph of some of the nodes has."""
        pairs, length = self._edges(belief, self.cells[kept])
        graph = csr_array((length, tuple(pairs.T)), shape=(int(kept.sum()),) * 2)
        return int(connected_components(graph, directed=False)[0])
