"""The nodes of a lattice graph with the frontier points in view of each, and what a network sees of such a graph."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.learners.attention.network import Array
from indoor_explorers.learners.published.lattice import Indices, Points, frontier_points, sightings


class Directions(NamedTuple):
    """What MARVEL's network sees besides, in bins of 10 degrees from the direction of the columns towards the rows."""

    frontiers: Array
    """(N, 36) frontier points in view by direction, scaled."""
    visited: Array
    """(N, 36), 1 where the UAV has looked in a direction from the node."""
    headings: Array
    """(M, 3, 36), what each of three headings at the nodes to choose from covers."""


class Observation(NamedTuple):
    """What a network sees: N nodes with F features, and M of them to choose from."""

    cells: Points
    """(N, 2) rows and columns."""
    features: Array
    """(N, F)."""
    near: Indices
    """(N, K) nodes that each node attends to, itself included, -1 where there are fewer."""
    own: int
    """The UAV's node."""
    options: Indices
    """(M,) nodes to choose from."""
    legal: Mask
    """(M,) bool, which of them the network may choose."""
    useful: Mask
    """(N,) bool, the nodes that it is worth flying to; without a reachable one the network has nothing to choose."""
    directions: Directions | None = None
    """For a network that sees directions."""


class Resolution(NamedTuple):
    """How lengths and frontier points of a publication are measured in cells of this world."""

    cells: float
    """Cells of one pixel or metre of the publication."""
    side: int
    """Cells of a block that has one frontier point at most."""
    weight: float
    """Frontier points of the publication that one point here stands for: its blocks may be finer than our cells."""


def resolution(lidar_range: float, published_range: float, published_block: float) -> Resolution:
    """Return the resolution at which a lidar range in cells is ``published_range``, in pixels or metres.

    ``published_block`` is the side of the publication's frontier blocks in the same unit.
    """
    cells = lidar_range / published_range
    side = max(1, round(published_block * cells))
    return Resolution(cells, side, side / (published_block * cells))


class SightedNodes:
    """Nodes, and the frontier points that were in view of each when the points appeared.

    As in the published code, a point is tested once for each node, when the node or the point is new; a node without
    points left is spent for good, and so is a visited one.
    """

    def __init__(self, shape: tuple[int, int], scale: Resolution, reach: float) -> None:
        self._width, self._size = shape[1], shape[0] * shape[1]
        self._scale, self._reach = scale, reach
        self.cells: Points = np.empty((0, 2), np.int64)
        """(N, 2) rows and columns."""
        self.spent: Mask = np.empty(0, np.bool_)
        """(N,) bool, nodes without utility for good."""
        self._seen: Indices = np.empty(0, np.int64)  # node * size + flat cell of a point, sorted
        self._points: Indices = np.empty(0, np.int64)  # flat cells of the points at the last look

    @property
    def utility(self) -> NDArray[np.float64]:
        """(N,) frontier points in view of each node, as many as the publication would count."""
        count = np.bincount(self._seen // self._size, minlength=len(self.cells))
        return np.where(self.spent, 0.0, count * self._scale.weight)

    def index(self, cell: Cell) -> int:
        """Return the node at a cell, -1 for none."""
        found = np.flatnonzero((self.cells == cell).all(axis=1))
        return int(found[0]) if len(found) else -1

    def nearest(self, cell: Cell) -> int:
        """Return the node nearest to a cell."""
        return int(np.square(self.cells - cell).sum(axis=1).argmin())

    def lacking(self, cells: Points) -> Points:
        """Return those of (K, 2) cells that are no node yet, without repetitions, in their order."""
        flat = cells @ (self._width, 1)
        _, first = np.unique(flat, return_index=True)
        kept = np.sort(first)
        return np.asarray(cells[kept[~np.isin(flat[kept], self.cells @ (self._width, 1))]])

    def look(self, belief: Belief, active: Mask | None = None, least: float = 0.0) -> None:
        """Renew the points of the nodes, those that have become a frontier and those that are none any more."""
        points = frontier_points(belief, self._scale.side) @ (self._width, 1)
        gone, fresh = np.setdiff1d(self._points, points), np.setdiff1d(points, self._points)
        self._points = points
        self.renew(belief, gone, fresh, np.ones(len(self.cells), np.bool_) if active is None else active, least)

    def renew(self, belief: Belief, gone: Indices, fresh: Indices, active: Mask, least: float) -> None:
        """Remove points ``gone`` and test points ``fresh``, flat cells, for ``active`` nodes (N,) that are not spent.

        Nodes whose utility is then at most ``least`` are spent.
        """
        active = active & ~self.spent
        lost = active[self._seen // self._size] & np.isin(self._seen % self._size, gone)
        self._seen = self._seen[~lost]
        self._see(belief, np.flatnonzero(active), fresh)
        self.spent |= active & (self.utility <= least)

    def add(self, belief: Belief, cells: Points, points: Indices | None = None, least: float = 0.0) -> None:
        """Add nodes at (K, 2) cells, that look for ``points``, flat cells, or for those of the last look.

        Nodes with a utility of at most ``least`` are spent.
        """
        fresh = np.arange(len(self.cells), len(self.cells) + len(cells))
        self.cells = np.concatenate([self.cells, cells])
        self.spent = np.concatenate([self.spent, np.zeros(len(cells), np.bool_)])
        self._see(belief, fresh, self._points if points is None else points)
        self.spent[fresh] = self.utility[fresh] <= least

    @property
    def seen(self) -> tuple[Indices, Indices]:
        """The pairs of a node and the flat cell of a point in view of it, (P,) each, spent nodes included."""
        return np.divmod(self._seen, self._size)

    def keep(self, kept: Mask) -> None:
        """Remove all nodes but those ``kept`` (N,)."""
        node, point = np.divmod(self._seen, self._size)
        self._seen = (np.cumsum(kept)[node] - 1)[kept[node]] * self._size + point[kept[node]]
        self.cells, self.spent = self.cells[kept], self.spent[kept]

    def _see(self, belief: Belief, nodes: Indices, points: Indices) -> None:
        at = np.stack(np.divmod(points, self._width), axis=1)
        pairs = sightings(belief, self.cells[nodes], at, self._reach)
        self._seen = np.union1d(self._seen, nodes[pairs[:, 0]] * self._size + points[pairs[:, 1]])
