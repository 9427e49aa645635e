"""RRT-based frontier detection: trees find the frontiers, a revenue picks one (Umari & Mukhopadhyay 2017)."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.search.frontiers import frontier_cells
from indoor_explorers.planners.sampling.points import centre, distances_to
from indoor_explorers.planners.sampling.samples import merged, tree_samples
from indoor_explorers.planners.sampling.segments import entries
from indoor_explorers.planners.sampling.trees import Tree, grow_tree
from indoor_explorers.planners.sampling.viewpoints import ViewpointPilot, ViewpointPolicy
from indoor_explorers.planners.toolbox.information.view_gain import unclaimed_gains
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.teammates import claims
from indoor_explorers.planners.toolbox.parameters import bounded

#: Doublings of the samples of a tree without a frontier, before the nearest frontier is searched exactly.
DOUBLINGS = 2


@renamed()
@dataclass(frozen=True, kw_only=True)
class RrtFrontier(ViewpointPolicy):
    """Grow trees into unknown space and fly to one of the cells where their edges enter it.

    As in the paper, a local tree, which finds the corners that the UAV is about to leave behind, and a global one
    provide the candidates. They are grown from scratch, as the map changes: the local one whenever the map has grown,
    the global one when the goal is no frontier cell any more.

    The goal is the first candidate in the order of lowest cost, which is computed whenever the map has grown. With
    ``as_published`` it is the candidate with the best revenue of the paper, ``gain_weight`` I h / R - d, computed when
    the old goal is no frontier cell any more: I the number of unknown cells visible from a candidate and not near a
    teammate's goal, h the hysteresis, R the lidar range in cells and d the path length in steps. The paper counts I in
    square metres with an information radius of one metre; dividing by R makes the weight independent of range and cell
    size (otherwise, with a long range, every candidate would be worth a flight across the map). The goal is sent to the
    teammates.

    H. Umari, S. Mukhopadhyay, "Autonomous robotic exploration based on multiple rapidly-exploring
    randomized trees", IROS 2017, doi:10.1109/IROS.2017.8202319.
    """

    discount_rate: float = 2.4
    local_samples: int = bounded(150, least=1)
    """Samples for the local tree, which is grown near the UAV whenever the map has grown."""
    global_samples: int = bounded(150, least=1)
    """Samples for the global tree, which is grown over the whole map when the goal is no frontier cell any more."""
    bias: float = bounded(0.5, least=0, tunable=(0.0, 1.0))
    """Share of the samples drawn from unknown cells next to known free ones; the others are uniform."""
    edge: float = bounded(4.0, least=0.5, tunable=(2.0, 12.0))
    """Longest edge of a tree in cells."""
    local_ranges: float = bounded(1.0, least=0.5, tunable=(0.5, 4.0))
    """Half the side of the square around the UAV that the local tree stays in, in lidar ranges."""
    latency: float = bounded(16.0, least=0, tunable=(1.0, 100.0, "log"))
    """Weight of the mean waiting time relative to the length of the order."""
    merge_distance: float = bounded(3.0, least=0, tunable=(0.0, 8.0))
    """Distance in cells below which candidates are merged."""
    as_published: bool = False
    """Whether to use the paper's revenue."""
    gain_weight: float = bounded(3.0, least=0)
    """Weight in the paper's revenue: lidar ranges of flight per squared lidar range of unknown cells (there: 3)."""
    hysteresis: float = bounded(2.0, least=0)
    """Factor on the gain of candidates near the UAV in the paper's revenue."""
    hysteresis_radius: float = bounded(3.0, least=0)
    """Distance from the UAV up to which it applies, in cells."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return RrtFrontierPilot(briefing, self)


class RrtFrontierPilot(ViewpointPilot):
    """Keep candidates between trees, as long as they are frontier cells."""

    def __init__(self, briefing: Briefing, policy: RrtFrontier) -> None:
        super().__init__(briefing, policy)
        self._policy = policy
        self._candidates = np.empty(0, np.int32)
        if policy.as_published:
            self.replan_period = inf  # the paper keeps its goal
        self.trees: list[Tree] = []
        """The trees that were grown since the map has changed, the local one first."""

    @property
    def frontier(self) -> NDArray[np.int32]:
        """The frontier cells that the trees have found, (K,) flat."""
        return self._candidates

    def on_map_growth(self, view: View) -> None:
        """Grow a local tree and add its candidates."""
        self.trees = []
        half = self._policy.local_ranges * self.briefing.lidar_range
        self._grow(view, half, self._policy.local_samples)

    def is_spent(self, view: View, goal: Cell) -> bool:
        """Tell whether a goal is no frontier cell any more."""
        return GoalPilot.is_spent(self, view, goal)

    def viewpoint(self, view: View) -> Cell | None:
        """Return the best candidate; None if the trees find none."""
        field = self.steps_from(view, view.cell)
        cells = self._detected(view, field)
        if not self._policy.as_published:
            return self.best(view, self.judged(view, cells), self._policy.latency)
        cells = cells[merged(cells, self._policy.merge_distance, self.paths.width, len(cells), self.paths.rise)]
        if not len(cells):
            return None
        revenue = self._revenue(view, cells, field)
        self.consider(cells, "revenue", revenue, steps=field.ravel()[cells])
        return divmod(int(cells[np.argmax(revenue)]), self.paths.width)

    def _detected(self, view: View, field: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return the candidates, (K,) flat cells, the nearest first.

        A global tree is grown if the goal is no frontier cell any more, and larger ones while nothing is found.
        """
        found = self._reachable(view, field)
        is_due = self.goal is None or self.is_spent(view, self.goal)
        for doubling in range(DOUBLINGS + 1):
            if len(found) and (doubling or not is_due):
                break
            self._grow(view, float(max(view.belief.shape)), self._policy.global_samples << doubling)
            found = self._reachable(view, field)
        return found[np.argsort(field.ravel()[found], kind="stable")]

    def _reachable(self, view: View, field: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return the candidates that are reachable and not banned."""
        found = self._candidates[field.ravel()[self._candidates] < UNREACHABLE]
        return found[~self.near_banned(view, found)]

    def _grow(self, view: View, half: float, samples: int) -> None:
        """Grow a tree in a square or cube around the UAV, and update the candidates."""
        rise = self.paths.rise
        points = tree_samples(view.belief, view.cell, half, samples, self._policy.bias, self.rng, rise)
        tree = grow_tree(view.belief, centre(view.cell, rise), points, self._policy.edge, rise)
        self.trees.append(tree)
        found = np.union1d(self._candidates, entries(view.belief, *tree, rise))
        self._candidates = found[frontier_cells(view.belief, found, rise)]

    def _revenue(self, view: View, cells: NDArray[np.int32], field: NDArray[np.int32]) -> NDArray[np.float64]:
        gains = unclaimed_gains(view.belief, cells, claims(view, self.briefing), self.lidar)
        away = distances_to(cells, view.cell, self.paths.width, self.paths.rise)
        near = away <= self._policy.hysteresis_radius
        weight = self._policy.gain_weight / self.briefing.lidar_range
        worth = weight * gains * np.where(near, self._policy.hysteresis, 1.0)
        return np.asarray(worth - field.ravel()[cells], np.float64)
