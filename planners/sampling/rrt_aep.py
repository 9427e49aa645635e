"""Autonomous exploration planning: a local random tree and stored viewpoints (Selin et al. 2019)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Distances, Mask
from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.sensing.lidar import LidarModel
from indoor_explorers.planners.sampling.points import centre, known_cells, points_in
from indoor_explorers.planners.sampling.rrt_nbv import RrtNbvPilot, TreePolicy
from indoor_explorers.planners.sampling.samples import tree_samples
from indoor_explorers.planners.sampling.segments import entries
from indoor_explorers.planners.sampling.trees import grow_tree
from indoor_explorers.planners.sampling.viewpoints import Viewpoints, diverse_subset
from indoor_explorers.planners.toolbox.coordination.sequence_chooser import SequenceChooser, SequenceParameters
from indoor_explorers.planners.toolbox.information.view_gain import WeightedGains
from indoor_explorers.planners.toolbox.navigation.candidate_pilot import CandidatePilot
from indoor_explorers.planners.toolbox.navigation.teammates import message_of
from indoor_explorers.planners.toolbox.parameters import GoalBonusParameters, bounded

#: Half the side of the inner square or cube around the UAV, in cells.
NEAR_HALF = 6.0
#: Largest distance of other viewpoints from a UAV of the group, in steps.
NEAR = 6
#: Steps after which a UAV chooses again if the map has grown, in lidar ranges.
PERIOD = 0.1
#: Most viewpoints that are evaluated at a time: the nearest ones.
JUDGED = 256


@renamed(hold=("goal_bonus", "switch_cost"), global_discount="global_discount_rate")
@dataclass(frozen=True, kw_only=True)
class RrtAep(GoalBonusParameters, TreePolicy):
    """Store the viewpoints that trees have found, and fly to the best of all of them.

    The paper alternates: receding-horizon next-best-view planning while the local tree has enough gain, else an
    RRT* to the stored viewpoint with the best g e^(-global_discount_rate d / R), d the path length along the RRT*;
    ``take_turns`` does this. Without it, a tree is grown near the UAV, densest around it, and from time to time one
    over the whole map. The next viewpoint is chosen among all new and stored ones as
    :class:`~indoor_explorers.planners.frontier.joint.FrontierJoint` chooses among frontier clusters: the best short
    sequence, minus the cost of the viewpoints left behind, linked UAVs in turn. ``share`` and ``switch_cost`` only
    affect ``take_turns``, ``goal_bonus`` only the choice without it.

    M. Selin, M. Tiger, D. Duberg, F. Heintz, P. Jensfelt, "Efficient autonomous exploration planning of large-scale
    3-D environments", IEEE RA-L 4(2), 2019, doi:10.1109/LRA.2019.2897343.
    """

    discount_rate: float = 2.4
    samples: int = 100
    """Samples for each tree."""
    near_samples: int = bounded(100, least=0, tunable=(0, 300))
    """Additional samples for the tree near the UAV, drawn from an inner square around it."""
    local_period: float = bounded(0.1, least=0, tunable=(0.05, 1.0, "log"))
    """Steps after which a tree is grown near the UAV if the map has grown, in lidar ranges."""
    global_period: float = bounded(1.0, least=0, tunable=(0.2, 4.0, "log"))
    """Steps after which a tree is grown over the whole map if the map has grown, in lidar ranges."""
    places: int = bounded(32, least=1)
    """Most viewpoints with different views to choose from."""
    lookouts: int = bounded(8, least=0, tunable=(0, 16))
    """Most other viewpoints near a UAV of the group to choose from."""
    order: float = bounded(0.3, least=0, tunable=(0.05, 2.0, "log"))
    """Weight of the cost of the clusters that a sequence leaves behind, per lidar range, against log(value)."""
    latency: float = bounded(3.0, least=0, tunable=(0.3, 30.0, "log"))
    """Weight of the mean waiting time relative to the length in that cost."""
    take_turns: bool = False
    """Whether to follow the paper: the local tree first, stored viewpoints if its gain is too small."""
    threshold: float = bounded(0.02, least=0)
    """Smallest gain of a local tree, and of a stored viewpoint, with ``take_turns``, as a share of the lidar's disc."""
    global_discount_rate: float = bounded(0.6, least=0)
    """Discount rate along the RRT*: gain * exp(-global_discount_rate * length / lidar_range)."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return TurnsPilot(briefing, self) if self.take_turns else RrtAepPilot(briefing, self)


def tree_cells(
    view: View, squares: Iterable[tuple[float, int]], bias: float, edge: float, rng: np.random.Generator, rise: int = 0
) -> NDArray[np.int32]:
    """Grow a tree from the UAV; return its known free cells, and those where it enters unknown space, flat.

    Each of the ``squares``, or cubes, around the UAV is given by half its side in cells and its number of samples; a
    share ``bias`` of them is drawn from unknown cells next to known free ones. ``edge`` is the longest edge in cells.
    """
    drawn = [tree_samples(view.belief, view.cell, half, count, bias, rng, rise) for half, count in squares]
    tree = grow_tree(view.belief, centre(view.cell, rise), np.concatenate(drawn), edge, rise)
    cells = known_cells(view.belief, tree.vertices, rise)
    return np.concatenate([cells[cells >= 0], entries(view.belief, *tree, rise)])


class ViewpointMemory:
    """The viewpoints that one UAV's trees have found, kept as long as they have a gain."""

    def __init__(self, briefing: Briefing, policy: TreePolicy, lidar: LidarModel) -> None:
        self._policy = policy
        self._rng, self._rise = briefing.rng, briefing.rise
        self._gains = WeightedGains(briefing.shape, lidar, policy.decay_length, policy.isolation)
        self._cells = np.empty(0, np.int32)

    def grow(self, view: View, *squares: tuple[float, int]) -> None:
        """Add the viewpoints of a tree with samples from squares around the UAV (:func:`tree_cells`)."""
        found = tree_cells(view, squares, self._policy.bias, self._policy.edge, self._rng, self._rise)
        self._cells = np.union1d(self._cells, found)

    def recalled(self, view: View, steps: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
        """Return the nearest viewpoints, (K,) flat cells, and their gains, (K,).

        ``steps`` (H*W,) are the path lengths. Unreachable viewpoints and those without a gain are removed.
        """
        cells = self._cells[(steps[self._cells] < UNREACHABLE) & ~view.visited.ravel()[self._cells]]
        cells = cells[np.argsort(steps[cells], kind="stable")]
        gains = self._gains.at(view.belief, cells[:JUDGED])
        good = cells[:JUDGED][gains > 0.0]
        self._cells = np.concatenate([good, cells[JUDGED:]])
        return good, gains[gains > 0.0]


class RrtAepPilot(CandidatePilot):
    """Choose among stored viewpoints, in turn with the linked teammates."""

    changes_levels: ClassVar[bool] = True
    straight = True

    def __init__(self, briefing: Briefing, policy: RrtAep) -> None:
        super().__init__(briefing)
        self._policy, self._range = policy, float(briefing.lidar_range)
        self.replan_period = self.steps_in(PERIOD)
        self._parameters = SequenceParameters(
            isolation=policy.isolation,
            decay_length=policy.decay_length,
            goal_bonus=policy.goal_bonus,
            order=policy.order,
            latency=policy.latency,
        )
        self.chooser = SequenceChooser(self, self._parameters, self.candidates)
        """Chooses among the viewpoints."""
        self._memory = ViewpointMemory(briefing, policy, self.lidar)
        self._next_local = self._next_global = self._fallbacks = 0

    def choose(self, view: View) -> Cell | None:
        """Return the viewpoint that this UAV gets in its turn, or the nearest frontier cell if none has a gain."""
        goal = self.chooser.choose(view)
        if goal is None:
            self._fallbacks += 1
            goal = self.nearest_frontier(view)
        self.message = message_of(goal)
        return goal

    def tally(self) -> dict[str, float]:
        """Return also the number of choices without any viewpoint that has a gain."""
        return super().tally() | {"fallbacks": float(self._fallbacks)}

    def candidates(self, view: View, fields: Distances) -> tuple[NDArray[np.int32], Mask]:
        """Return viewpoints with different views and others near a UAV, (K,), and which are the former ones, (K,)."""
        policy = self._policy
        self._grow_trees(view)
        steps = fields.min(axis=0).ravel()
        cells, gains = self._memory.recalled(view, steps)
        scores = np.log(gains) - policy.discount_rate * steps[cells] / self._range
        tried, rise = 2 * policy.places, self.paths.rise
        different = diverse_subset(view.belief, cells, scores, self.lidar, tried, policy.places, rise)
        values = np.sqrt(gains) * np.exp(-self._parameters.discount_rate * steps[cells] / self._range)
        near = np.setdiff1d(np.flatnonzero(steps[cells] <= NEAR), different)
        near = near[np.argsort(-values[near], kind="stable")[: policy.lookouts]]
        return cells[np.concatenate([different, near])], np.arange(len(different) + len(near)) < len(different)

    def _grow_trees(self, view: View) -> None:
        """Grow the trees that are due: all of them if the goal has no gain left."""
        memory, policy = self._memory, self._policy
        spent = self.goal is None or self.is_spent(view, self.goal)
        if spent or view.step >= self._next_local:
            near, half = (NEAR_HALF, policy.near_samples), policy.local_ranges * self._range
            memory.grow(view, near, (half, policy.samples))
            self._next_local = view.step + round(policy.local_period * self._range)
        if spent or view.step >= self._next_global:
            memory.grow(view, (float(max(view.belief.shape)), policy.samples))
            self._next_global = view.step + round(policy.global_period * self._range)


class TurnsPilot(RrtNbvPilot):
    """Follow the local tree while it has enough gain, else an RRT* to stored viewpoints."""

    def __init__(self, briefing: Briefing, policy: RrtAep) -> None:
        super().__init__(briefing, policy)
        self._aep = policy
        self._remembered = np.empty(0, np.int32)
        self._enough = policy.threshold * self.largest_view

    def viewpoint(self, view: View) -> Cell | None:
        """Return the local tree's best viewpoint, or else the best stored one."""
        policy = self._aep
        half = policy.local_ranges * self.briefing.lidar_range
        found = tree_cells(view, [(half, policy.samples)], policy.bias, policy.edge, self.rng, self.paths.rise)
        viewpoints = self.judged(view, np.union1d(self._remembered, found))
        good = viewpoints.gains > self._enough
        self._remembered = viewpoints.cells[good]
        if (good & np.isin(viewpoints.cells, found)).any():
            return super().viewpoint(view)
        return self._farther(view, viewpoints.selected(good))

    def _farther(self, view: View, viewpoints: Viewpoints) -> Cell | None:
        """Return the viewpoint of largest discounted gain along the paths of an RRT*."""
        if not len(viewpoints.cells):
            return None
        free = np.flatnonzero(view.belief.ravel() == FREE).astype(np.int32)
        drawn = self.rng.choice(free, self._aep.samples)
        drawn, rise = np.concatenate([viewpoints.cells, drawn, viewpoints.cells]), self.paths.rise
        samples, root = points_in(drawn, self.paths.width, rise, self.rng), centre(view.cell, rise)
        tree = grow_tree(view.belief, root, samples, self._aep.edge, rise, optimal=True, into_unknown=False)
        cells, lengths = known_cells(view.belief, tree.vertices, rise), tree.lengths()
        ways = np.array([np.min(lengths[cells == cell], initial=np.inf) for cell in viewpoints.cells])
        if not np.isfinite(ways).any():
            return self.best(view, viewpoints, self._aep.latency)
        scores = viewpoints.gains * np.exp(-self._aep.global_discount_rate / self.briefing.lidar_range * ways)
        return divmod(int(viewpoints.cells[np.argmax(scores)]), self.paths.width)
