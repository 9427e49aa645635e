"""What IR2's network sees: the graph of D. M. S. Tan, Y. Ma, J. Liang, Y. C. Chng, Y. Cao, G. Sartoretti, IROS 2024.

arXiv:2409.04730. Written from the paper and from what the released code computes. Around the UAV nodes are the free
points of a lattice; elsewhere those of a sparse global graph (:mod:`.routes`) along the ways of the team. Features of a
node: column and row from the corner of the map in 1,000 pixels, frontier points in view in 50, the rendezvous utility,
visits by the UAV, and 1 for a teammate's node, -1 for the UAV's. The rendezvous utility leads to a teammate out of
contact: it grows with the cells that the UAV knows and the teammate did not at their last contact.

As in our other planners, a teammate counts while it may still fly (:func:`remembered`); the published code looks at the
true map to see that it is gone.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.learners.published import lattice
from indoor_explorers.learners.published.checkpoint import Published, Sizes
from indoor_explorers.learners.published.lattice import Indices, Points
from indoor_explorers.learners.published.routes import GlobalGraph
from indoor_explorers.learners.published.sighted import Observation, SightedNodes, resolution
from indoor_explorers.planners.toolbox.peers.ir2 import IR2

_CODE = IR2.with_files(
    {
        "model.py": "2a0c4d91497fc5b5db981e2b91f1b8ed4ed11550bfaee3a67c5d6d1a967fd637",
        "test_multi_robot_worker.py": "f8ac603e8f7119064423f03dc0887ac3c2aa4c4d2b3da3ccc9709956d56190c4",
    }
)
NETWORK = Published(_CODE, "model/stage2/checkpoint.pth", Sizes(inputs=6, heads=8))
#: Pixels: the lidar range, the range within which frontier points count, and the side of the blocks that have one.
RANGE, UTILITY_RANGE, BLOCK = 80.0, 70.0, 4.0
#: Pixels between nodes: 50 over the 1,000 pixels of the maps that the released weights were trained on last.
SPACING = 999 / 49
NEIGHBOURS = 30
#: Pixels of the lattice kept around the UAV and around teammates, to each side.
AROUND_UAV, AROUND_MATE = 80.0, 20.0
#: Pixels within which nodes share the rendezvous utility of a way, without it around the UAV, and steps of the way.
SHARED, WITHOUT, STRIDE = 50.0, 30.0, 30.0
#: Least share of the map that makes a rendezvous worthwhile; factor of the share, and the least utility of its way.
LEAST_SHARE, SHARE, CONSTANT = 0.01, 8.0, 0.1
PIXELS, POINTS = 1000.0, 50.0


class Ir2Graph:
    """The graph of one UAV in one episode, updated at each of its choices."""

    def __init__(self, shape: tuple[int, int], lidar_range: float) -> None:
        scale = resolution(lidar_range, RANGE, BLOCK)
        self._cells = scale.cells
        self._lattice = lattice.lattice_points(shape, (SPACING * scale.cells, SPACING * scale.cells))
        self._nodes = SightedNodes(shape, scale, UTILITY_RANGE * scale.cells)
        self.routes = GlobalGraph(shape, scale.cells)
        self._way: list[Cell] = []

    def observe(self, belief: Belief, cell: Cell, mates: Mapping[Cell, float] | None = None) -> Observation:
        """Return what the network sees of a map (H, W) uint8 from a free cell, at which the UAV then has been.

        ``mates``: cells of the teammates; for those out of contact, the share of the map that is new for them, else 0.
        """
        nodes, mates = self._nodes, mates or {}
        if self._way and self._way[-1] != cell:
            self.routes.add([cell])
            nodes.spent[nodes.nearest(cell)] = True
        if not self._way or self._way[-1] != cell:
            self._way.append(cell)
        nodes.look(belief)
        self._renew(belief, cell, list(mates))
        self.routes.branch_off(belief, cell, nodes.cells, nodes.utility)
        self.routes.thin(belief, len(self._way), [cell, *mates])
        self._renew(belief, cell, list(mates))
        return self._observation(belief, cell, mates)

    def _renew(self, belief: Belief, cell: Cell, mates: list[Cell]) -> None:
        """Keep the nodes of the global graph, of the UAVs and of the lattice around these; add those that are new."""
        nodes, first = self._nodes, not len(self._nodes.cells)
        around = [self._lattice_around(belief, mate, AROUND_MATE) for mate in mates]
        own = self._lattice[belief[tuple(self._lattice.T)] == FREE]
        own = own if first else self._lattice_around(belief, cell, AROUND_UAV)
        wanted = np.concatenate([np.array([cell, *mates]), own, *around, self.routes.cells])
        if not first:
            width = belief.shape[1]
            nodes.keep(np.isin(nodes.cells @ (width, 1), wanted @ (width, 1)))
        nodes.add(belief, nodes.lacking(wanted))

    def _lattice_around(self, belief: Belief, cell: Cell, pixels: float) -> Points:
        """Return the points of the lattice in a window around a cell, connected with it inside the window."""
        half = max(1, round(pixels * self._cells))
        low = np.maximum(np.array(cell) - half, 0)
        window = belief[low[0] : cell[0] + half, low[1] : cell[1] + half] == FREE
        parts, _ = label(window)
        points = self._lattice - low
        points = points[(points >= 0).all(axis=1) & (points < window.shape).all(axis=1)]
        own = parts[cell[0] - low[0], cell[1] - low[1]]
        return np.asarray(points[(parts[tuple(points.T)] == own) & (own > 0)] + low)

    def _observation(self, belief: Belief, cell: Cell, mates: Mapping[Cell, float]) -> Observation:
        cells, utility = self._nodes.cells, self._nodes.utility
        own, near = self._nodes.index(cell), self._edges(belief)
        visits, occupied = np.zeros(len(cells)), np.zeros(len(cells))
        np.add.at(visits, [self._nodes.nearest(each) for each in self._way], 1.0)
        occupied[[self._nodes.index(mate) for mate in mates]] = 1.0
        occupied[own] = -1.0
        rendezvous = self._rendezvous(belief, near, own, mates)
        place = cells[:, ::-1] / self._cells / PIXELS
        features = np.column_stack([place, utility / POINTS, rendezvous, visits, occupied]).astype(np.float32)
        options = near[own]
        useful = (utility > 0) | (rendezvous > 0)
        return Observation(cells, features, near, own, options, (options > 0) & (options != own), useful)

    def _edges(self, belief: Belief) -> Indices:
        """Return the nodes (N, K) that each node leads to: by long edges of the global graph, then to the nearest."""
        cells = self._nodes.cells
        long = self.routes.long_edges(belief, cells, AROUND_UAV, NEIGHBOURS)
        near = lattice.nearest(cells, cells, NEIGHBOURS)
        room = np.arange(near.shape[1]) < NEIGHBOURS - (long >= 0).sum(axis=1, keepdims=True)
        repeated = (near[:, :, None] == long[:, None]).any(axis=2)
        short = lattice.straight_edges(belief, cells, np.where(room & ~repeated, near, -1))
        return lattice.moved_left(np.concatenate([long, short], axis=1))[:, :NEIGHBOURS]

    def _rendezvous(self, belief: Belief, near: Indices, own: int, mates: Mapping[Cell, float]) -> NDArray[np.float64]:
        """Return the rendezvous utility (N,): along the ways to teammates out of contact, most at their ends."""
        found = np.zeros(len(self._nodes.cells))
        apart = {mate: share for mate, share in mates.items() if share >= LEAST_SHARE}
        if apart:
            length, before = lattice.walks(self._nodes.cells, near, own)
            for mate, share in apart.items():
                end = self._nodes.index(mate)
                if end != own and np.isfinite(length[end]):
                    way = self._nodes.cells[lattice.walk_to(before, end)]
                    found = np.maximum(found, self._along(belief, self._filled(way), SHARE * share))
        found[self._within(self._nodes.cells[own], WITHOUT)] = 0.0
        return found

    def _filled(self, way: Points) -> Points:
        """Return the points of a way with more between those at least one stride apart."""
        out = [way[:1]]
        for start, end in pairwise(way):
            parts = int(np.hypot(*(end - start)) // (STRIDE * self._cells)) + 1
            out.append(np.round(start + np.arange(1, parts + 1)[:, None] / parts * (end - start)).astype(np.int64))
        return np.concatenate(out)

    def _along(self, belief: Belief, way: Points, most: float) -> NDArray[np.float64]:
        """Return the utility (N,) of the nodes in sight of a way: ``most`` at its end, falling evenly to its start."""
        found = np.zeros(len(self._nodes.cells))
        for k, point in enumerate(way[::-1]):
            close = np.flatnonzero(self._within(point, SHARED))
            sight = close[lattice.clear_lines(belief, np.tile(point, (len(close), 1)), self._nodes.cells[close])]
            found[sight] = np.maximum(found[sight], most - k * most / len(way) + CONSTANT)
        return found

    def _within(self, point: Points, pixels: float) -> Mask:
        return np.asarray(np.hypot(*(self._nodes.cells - point).T) <= pixels * self._cells)
