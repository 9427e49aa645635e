"""Autonomous exploration planning: a local random tree and remembered viewpoints (Selin et al. 2019)."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Cell
from indoor_explorers.env.grid import FREE
from indoor_explorers.env.policy import Pilot
from indoor_explorers.env.view import Briefing, View
from indoor_explorers.planners.parameters import at_least
from indoor_explorers.planners.sampling.rrt_nbv import RrtNbv, RrtNbvPilot
from indoor_explorers.planners.sampling.samples import box_around, known_cells, points_in, tree_samples
from indoor_explorers.planners.sampling.segments import entries
from indoor_explorers.planners.sampling.trees import grow_tree
from indoor_explorers.planners.sampling.viewpoints import Viewpoints


@dataclass(frozen=True, kw_only=True)
class RrtAep(RrtNbv):
    """Remember the viewpoints that trees have found, and fly to the best of all of them.

    The paper takes turns: receding-horizon next-best-view planning while the local tree promises enough, else an
    RRT* to the remembered viewpoint with the best g e^(-global_discount d / R), d the length of the way along the
    RRT*; ``take_turns`` does that. Without it all viewpoints, of the local tree, of one over the whole map and those
    remembered, go into one order, the cheapest of a travelling repairman
    (:mod:`indoor_explorers.planners.frontier.orders`), and the UAV flies to the first.

    M. Selin, M. Tiger, D. Duberg, F. Heintz, P. Jensfelt, "Efficient autonomous exploration planning of large-scale
    3-D environments", IEEE RA-L 4(2), 2019, doi:10.1109/LRA.2019.2897343.
    """

    discount: float = 2.4
    """How fast promises fade with the way to them: by a factor e for this share of a step per lidar range."""
    samples: int = 100
    """Samples for each tree."""
    take_turns: bool = False
    """True for the paper's order: the local tree first, remembered viewpoints when it promises too little."""
    threshold: float = 0.02
    """What a local tree must promise at least, and a viewpoint to be remembered, as a share of the lidar's disc."""
    global_discount: float = 0.6
    """How fast promises fade with the way along the RRT*: by a factor e for this share of a step per lidar range."""
    latency: float = 16.0
    """Weight of the mean waiting time beside the length of the order."""

    def __post_init__(self) -> None:
        super().__post_init__()
        at_least(self, 0.0, "threshold", "global_discount", "latency")

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the mind of one UAV."""
        return RrtAepPilot(briefing, self)


class RrtAepPilot(RrtNbvPilot):
    """Remember viewpoints until they promise nothing any more."""

    def __init__(self, briefing: Briefing, policy: RrtAep) -> None:
        super().__init__(briefing, policy)
        self._aep = policy
        self._remembered = np.empty(0, np.int32)
        self._enough = policy.threshold * pi * briefing.lidar_range**2 if policy.take_turns else 0.0

    def viewpoint(self, view: View) -> Cell | None:
        """Return the best viewpoint of all, or first the local tree's and then the best remembered one."""
        half = self._aep.local_ranges * self.briefing.lidar_range
        found = [self._remembered, self._seen(view, half)]
        if not self._aep.take_turns:
            found.append(self._seen(view, float(max(view.belief.shape))))
        viewpoints = self.judged(view, np.unique(np.concatenate(found)))
        good = viewpoints.promises > self._enough
        self._remembered = viewpoints.cells[good]
        if not self._aep.take_turns:
            return self.best(view, viewpoints, self._aep.latency)
        near = np.isin(viewpoints.cells, found[1])
        if (good & near).any():
            return super().viewpoint(view)
        return self._farther(view, viewpoints.those(good))

    def _seen(self, view: View, half: float) -> NDArray[np.int32]:
        """Grow a tree in a square around the UAV; return its known free cells and where it gets into the unknown."""
        low, high = box_around(view.cell, half, view.belief.shape)
        drawn = tree_samples(view.belief, low, high, self._aep.samples, self._aep.bias, self.rng)
        tree = grow_tree(view.belief, (view.cell[0] + 0.5, view.cell[1] + 0.5), drawn, self._aep.edge)
        cells = known_cells(view.belief, tree.vertices)
        return np.concatenate([cells[cells >= 0], entries(view.belief, *tree)])

    def _farther(self, view: View, viewpoints: Viewpoints) -> Cell | None:
        """Return the viewpoint to which an RRT* finds the way with the best discounted promise."""
        if not len(viewpoints.cells):
            return None
        free = np.flatnonzero(view.belief.ravel() == FREE).astype(np.int32)
        drawn = self.rng.choice(free, self._aep.samples)
        samples = points_in(np.concatenate([viewpoints.cells, drawn, viewpoints.cells]), self.paths.width, self.rng)
        root = (view.cell[0] + 0.5, view.cell[1] + 0.5)
        tree = grow_tree(view.belief, root, samples, self._aep.edge, optimal=True, into_unknown=False)
        cells, lengths = known_cells(view.belief, tree.vertices), tree.lengths()
        ways = np.array([np.min(lengths[cells == cell], initial=np.inf) for cell in viewpoints.cells])
        if not np.isfinite(ways).any():
            return self.best(view, viewpoints, self._aep.latency)
        scores = viewpoints.promises * np.exp(-self._aep.global_discount / self.briefing.lidar_range * ways)
        return divmod(int(viewpoints.cells[np.argmax(scores)]), self.paths.width)
