"""Receding-horizon next-best-view planning on a random tree (Bircher et al. 2016)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.sampling.points import Points, centre, known_cells
from indoor_explorers.planners.sampling.samples import tree_samples
from indoor_explorers.planners.sampling.trees import Tree, grow_tree
from indoor_explorers.planners.sampling.viewpoints import ViewpointPilot, ViewpointPolicy, Viewpoints
from indoor_explorers.planners.toolbox.parameters import bounded


@renamed()
@dataclass(frozen=True, kw_only=True)
class TreePolicy(ViewpointPolicy):
    """Parameters of all planners that find viewpoints with random trees."""

    samples: int = bounded(200, least=1, tunable=(50, 400, "log"))
    """Samples for a tree, which has at most one vertex more."""
    bias: float = bounded(0.5, least=0, tunable=(0.0, 1.0))
    """Share of the samples drawn from unknown cells next to known free ones; the others are uniform."""
    edge: float = bounded(6.0, least=0.5, tunable=(2.0, 12.0))
    """Longest edge of a tree in cells."""
    local_ranges: float = bounded(2.0, least=0.5, tunable=(0.5, 4.0))
    """Half the side of the square around the UAV that the samples are drawn from, in lidar ranges."""


@renamed()
@dataclass(frozen=True, kw_only=True)
class RrtNbv(TreePolicy):
    """Grow an RRT from the UAV, fly along the first edge of its best branch, and grow the next one from there.

    The value of a branch is the sum of its vertices' gains, discounted by e^(-discount_rate c / R): c the path
    length along the tree and R the lidar range. The remainder of the best branch is the start of the next tree. If
    the tree has no gain, the paper's planner is stuck; this one flies to the nearest frontier cell.

    A. Bircher, M. Kamel, K. Alexis, H. Oleynikova, R. Siegwart, "Receding horizon 'next-best-view' planner for 3D
    exploration", ICRA 2016, doi:10.1109/ICRA.2016.7487281.
    """

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return RrtNbvPilot(briefing, self)


class RrtNbvPilot(ViewpointPilot):
    """Keep the remainder of the best branch between trees."""

    def __init__(self, briefing: Briefing, policy: TreePolicy) -> None:
        super().__init__(briefing, policy)
        self._policy = policy
        self._remainder: Points = np.empty((0, self.axes))
        self.tree: Tree | None = None
        """The tree that was grown last."""
        self.branch = np.empty(0, np.int64)
        """The vertices of its best branch, from the root on."""

    def viewpoint(self, view: View) -> Cell | None:
        """Return the first cell of the best branch that the UAV has not visited."""
        tree = self.grow(view)
        cells = known_cells(view.belief, tree.vertices, self.paths.rise)
        viewpoints = self.judged(view, np.unique(cells[cells >= 0]))
        worth = self._values(tree, cells, viewpoints)
        self.tree, self.branch = tree, best_branch(tree, worth)
        self.consider(
            viewpoints.cells,
            "gain; the best branch counts",
            viewpoints.gains,
            gain=viewpoints.gains,
            steps=viewpoints.steps,
        )
        self._remainder = tree.vertices[self.branch[1:]]
        new = [cell for cell in cells[self.branch].tolist() if cell in viewpoints.cells]
        return divmod(new[0], self.paths.width) if new else None

    def grow(self, view: View) -> Tree:
        """Grow a tree near the UAV, first towards the remainder of the last best branch."""
        policy, rise = self._policy, self.paths.rise
        half, count = policy.local_ranges * self.briefing.lidar_range, policy.samples - len(self._remainder)
        drawn = tree_samples(view.belief, view.cell, half, count, policy.bias, self.rng, rise)
        samples = np.concatenate([self._remainder, drawn])
        return grow_tree(view.belief, centre(view.cell, rise), samples, policy.edge, rise, into_unknown=False)

    def _values(self, tree: Tree, cells: NDArray[np.int32], viewpoints: Viewpoints) -> NDArray[np.float64]:
        """Return the discounted gain of each of (K,) vertices in known free cells, 0 for the others."""
        gains = np.zeros(self.briefing.shape[0] * self.paths.width + 1)
        gains[viewpoints.cells] = viewpoints.gains
        rate = self._policy.discount_rate / self.briefing.lidar_range
        return np.asarray(gains[cells] * np.exp(-rate * tree.lengths()))


def best_branch(tree: Tree, values: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the vertices of the branch with the largest sum of (K,) ``values``, from the root on.

    The branch ends at its last vertex with a positive value.
    """
    sums = values.copy()
    parents = tree.parents.tolist()
    for vertex, parent in enumerate(parents[1:], start=1):
        sums[vertex] += sums[parent]
    branch = [int(np.argmax(sums))]
    while parents[branch[-1]] >= 0:
        branch.append(parents[branch[-1]])
    return np.array(branch[::-1], np.int64)
