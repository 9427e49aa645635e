"""What ARiADNE's network sees: the informative graph of Y. Cao, T. Hou, Y. Wang, X. Yi, G. Sartoretti, ICRA 2023.

arXiv:2301.11575. Written from the paper and from what the released code computes. Nodes are the free points of a
lattice over the map and the start; each has edges along clear lines to some of the 20 nearest ones, itself included.
Features of a node: column and row from the corner of the map in 640 pixels, frontier points in view in 50, and whether
the UAV has been there. Where 80 pixels are a lidar range of 80 cells, the graphs are those of the released code.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.learners.published.checkpoint import Published, Sizes
from indoor_explorers.learners.published.lattice import lattice_points, nearest, straight_edges
from indoor_explorers.learners.published.sighted import Observation, SightedNodes, resolution
from indoor_explorers.planners.toolbox.peers.clone import PublishedCode

_CODE = PublishedCode(
    url="https://github.com/marmotlab/ARiADNE",
    commit="8d726ad05e6b0c38672f1679baf7fa2b083a0eb0",
    files={
        "model.py": "7e886218754071e1511393db8d4762d86c4366c254c022d785793fb30b8c11f1",
        "graph_generator.py": "8f8495c66b4fdb03fd33b8bb956069c1d194492071b057a59c73528d73b6e7df",
        "node.py": "275832187211efd11b45b34b163ee9066b249f612acb0ddf6e1ed0e110cb1627",
        "env.py": "50715ee68e6a6c5c3e298f1a88f20337bd67f6781c14352701be3e6a481b43dc",
        "test_worker.py": "9cdcfabf568a5844ffc611bb44e85caf2b85131525025768814867fc714d2fd3",
    },
)
NETWORK = Published(_CODE, "model/ae_clean/checkpoint.pth", Sizes(inputs=4, heads=8))
#: Pixels: the lidar range, the range within which frontier points count, and the side of the blocks that have one.
RANGE, UTILITY_RANGE, BLOCK = 80.0, 70.0, 4.0
#: Pixels between rows and between columns of the lattice: 30 over 480 and 640 pixels.
SPACING = (479 / 29, 639 / 29)
NEIGHBOURS = 20
#: Divisors of the features: pixels and frontier points. A node with at most so many points left is spent.
PIXELS, POINTS, LEAST = 640.0, 50.0, 2.0


class AriadneGraph:
    """The graph of one UAV in one episode, updated at each of its choices."""

    def __init__(self, shape: tuple[int, int], lidar_range: float) -> None:
        self._scale = resolution(lidar_range, RANGE, BLOCK)
        self._lattice = lattice_points(shape, (SPACING[0] * self._scale.cells, SPACING[1] * self._scale.cells))
        self._nodes = SightedNodes(shape, self._scale, UTILITY_RANGE * self._scale.cells)
        self._visited: set[Cell] = set()

    def observe(self, belief: Belief, cell: Cell) -> Observation:
        """Return what the network sees of a map (H, W) uint8 from a free cell, at which the UAV then has been."""
        nodes = self._nodes
        close = np.hypot(*(nodes.cells - cell).T) <= 2 * RANGE * self._scale.cells
        if self._visited:
            if nodes.index(cell) >= 0:
                nodes.spent[nodes.index(cell)] = True
            nodes.look(belief, close, LEAST)
        else:
            nodes.look(belief)
        free = self._lattice[belief[tuple(self._lattice.T)] == FREE]
        nodes.add(belief, nodes.lacking(np.concatenate([np.array([cell]), free])))
        if self._visited:
            nodes.spent[nodes.index(cell)] = True
        self._visited.add(cell)
        return self._observation(belief, nodes.index(cell))

    def _observation(self, belief: Belief, own: int) -> Observation:
        cells, utility = self._nodes.cells, self._nodes.utility
        near = straight_edges(belief, cells, nearest(cells, cells, NEIGHBOURS))
        place = cells[:, ::-1] / self._scale.cells / PIXELS
        visited = [tuple(each) in self._visited for each in cells.tolist()]
        features = np.column_stack([place, utility / POINTS, visited]).astype(np.float32)
        options = near[own]
        return Observation(cells, features, near, own, options, (options > 0) & (options != own), utility > 0)
