"""POMDP: fly to the frontier cluster with the largest return in simulated explorations (Silver & Veness 2010)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell, Distances
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.sensing.lidar import lidar_model
from indoor_explorers.planners.pomdp.completions import completions, pocket_sizes, strata
from indoor_explorers.planners.pomdp.tree import Problem, isolation_weights, search
from indoor_explorers.planners.toolbox.coordination.independent_pilot import IndependentPilot
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters, frontier_clusters, nearest_cells
from indoor_explorers.planners.toolbox.information.view_gain import WeightedGains
from indoor_explorers.planners.toolbox.parameters import (
    DiscountParameters,
    GoalBonusParameters,
    ReplanParameters,
    bounded,
)
from indoor_explorers.planners.toolbox.pockets.estimates import PocketEstimator
from indoor_explorers.planners.toolbox.pockets.outlook import EstimateUser

#: Distance within which a cluster counts as at the current goal, in lidar ranges.
SAME = 0.5
#: Distance over which an unknown cell's weight falls to 1 / e where macro actions are preselected, in lidar ranges.
DECAY_LENGTH = 0.5

Numbers = NDArray[np.float64]


@renamed(rate="discount_rate", hold="goal_bonus")
@dataclass(frozen=True, kw_only=True)
class Pomdp(EstimateUser, DiscountParameters, GoalBonusParameters, ReplanParameters, Policy):
    """Fly to the frontier cluster of the best macro action by POMCP over completions of the map.

    The hidden state of the POMDP is the map, its belief a set of completions that agree with all that is known: a small
    network tells how much unknown free space is probably behind each cluster, and a completion takes these sizes at one
    quantile (:mod:`indoor_explorers.planners.pomdp.completions`). The estimates are learned from other maps and read
    the UAV's belief alone, never the generator. A fixed number of simulations builds a tree of macro actions and
    observations by upper confidence bounds and ends with a rollout to nearest frontiers
    (:mod:`indoor_explorers.planners.pomdp.tree`). The return is the weight of the cells that become known within the
    horizon, discounted by the steps until then; isolated cells weigh more, since a pocket left behind costs a detour
    after the horizon. The cluster with the largest mean return becomes the goal; the plan is made anew when it is
    explored, and after ``period`` if the map has grown.

    Only the nearest part of the map is simulated; with no cluster in it the UAV flies to its nearest frontier
    (``out_of_range`` in the tally). Teammates are not simulated: pockets behind clusters near the goals of linked ones
    are worth less, as are those left to teammates out of contact (:class:`OutOfContact`).

    Differences: new completions are drawn for every plan from the present belief, where POMCP filters particles by the
    observations; an observation is the class of size of a macro action's newly known area, since scans of completions
    never repeat; and the returns of all first actions are averaged over the same completions.

    Weaknesses: rollouts to nearest frontiers blur the differences between first actions. Even with the true map as the
    only completion it was only about as fast as ``frontier`` in rooms; with estimated completions it is slower to 99 %,
    and a plan takes several times as long.

    D. Silver, J. Veness, "Monte-Carlo planning in large POMDPs", NeurIPS 2010. Exploration as a POMDP by forward
    simulation: M. Lauri, R. Ritala, "Planning for robotic exploration based on forward simulation", Robotics and
    Autonomous Systems 83, 2016, doi:10.1016/j.robot.2016.06.008. The completions are this project's.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    simulations: int = bounded(48, least=1)
    """Simulations of a decision."""
    maps: int = bounded(8, least=1)
    """Completions of the map that are drawn for a decision."""
    scale: float = bounded(3.0, least=0)
    """Factor on the sizes of pockets: in small ones a simulated flight gets stuck at once, whatever it tries."""
    actions: int = bounded(8, least=1, tunable=(2, 16))
    """Most clusters to choose among: those with the largest sqrt(view gain) e^(-discount_rate d / R)."""
    tree: int = bounded(2, least=1, tunable=(1, 4))
    """Most macro actions in the tree, before nearest frontiers."""
    horizon: float = bounded(6.0, least=1, tunable=(2.0, 12.0))
    """Simulated steps, in lidar ranges."""
    discount_rate: float = 1.2
    """Discount rate of newly known cells, per lidar range of flight."""
    exploration: float = bounded(1.0, least=0, tunable=(0.1, 4.0, "log"))
    """Factor of the confidence bounds, in units of the range of returns."""
    isolation: float = bounded(16.0, least=0, tunable=(1.0, 64.0, "log"))
    """Additional weight of an unknown cell that is surrounded by known ones."""
    dimming: float = bounded(0.8, least=0, most=1, tunable=(0.0, 1.0))
    """Share of its value that a pocket loses for each linked teammate that flies near it, 0 to 1."""
    period: float = 0.3

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return PomdpPilot(briefing, self)


class PomdpPilot(IndependentPilot):
    """Plan by simulations, and fly to the cluster of the best first macro action."""

    def __init__(self, briefing: Briefing, policy: Pomdp) -> None:
        super().__init__(briefing)
        self._policy = policy
        self._horizon = max(2, round(policy.horizon * self._lidar))
        self._gains = WeightedGains(briefing.shape, self._lidar, DECAY_LENGTH, policy.isolation)
        self._estimator = PocketEstimator(self._lidar, path=policy.estimate_files.plain)
        self.replan_period = self.steps_in(policy.period)

    def chosen(self, view: View) -> Cell | None:
        """Return the nearest cell of the cluster with the largest return."""
        policy = self._policy
        clusters = frontier_clusters(view.belief, self._lidar)
        cells, steps = nearest_cells(self.steps_from(view, view.cell), clusters)
        fine = (steps > 0) & (steps < self._horizon) & ~self.near_banned(view, cells)
        if not fine.any():
            return None
        factors = self._factors(view, cells, steps)
        worth = (
            factors * np.sqrt(self._gains.at(view.belief, cells)) * np.exp(-policy.discount_rate / self._lidar * steps)
        )
        chosen = np.argsort(np.where(fine, -worth, np.inf), kind="stable")[: min(policy.actions, int(fine.sum()))]
        if len(chosen) == 1:
            return divmod(int(cells[chosen[0]]), self.paths.width)
        problem = self._problem(view, clusters, cells[chosen], factors)
        values, _ = search(
            problem, lidar_model(self._lidar), policy.simulations, policy.tree, float(policy.exploration)
        )
        returns = values * self._bonus(cells[chosen])
        self.consider(cells[chosen], "simulated return", returns, worth=worth[chosen], steps=steps[chosen])
        best = chosen[np.argmax(returns)]
        return divmod(int(cells[best]), self.paths.width)

    def _problem(self, view: View, clusters: Clusters, goals: NDArray[np.int32], factors: Numbers) -> Problem:
        """Return the decision problem in the part of the map that can be simulated."""
        policy = self._policy
        tails = self._estimator.estimate(view.belief, clusters).tails
        sizes = pocket_sizes(tails, strata(policy.maps, self.rng), policy.scale)
        window = Window(view.belief, view.cell, self._horizon + int(self._lidar) + 1)
        drawn = completions(window.belief, window.clusters(clusters), sizes)
        return Problem(
            belief=window.belief,
            start=int(window.flat(self.paths.flat([view.cell]))[0]),
            goals=window.flat(goals),
            maps=drawn.maps,
            owners=drawn.owners,
            factors=factors,
            weights=isolation_weights(window.belief, policy.isolation),
            discount=float(np.exp(-policy.discount_rate / self._lidar)),
            horizon=self._horizon,
        )

    def _factors(self, view: View, cells: NDArray[np.int32], steps: Distances) -> Numbers:
        """Return the factors on the value of (K,) clusters for teammates, (K,)."""
        return self.left_by_others(view, cells, steps) * self.not_dimmed(view, cells, self._policy.dimming)

    def _bonus(self, cells: NDArray[np.int32]) -> Numbers:
        """Return ``1 + goal_bonus`` for (K,) flat cells near the current goal, else 1, (K,)."""
        return self.goal_factors(self.goal, cells, SAME * self._lidar, self._policy.goal_bonus)


class Window:
    """The part of a (H, W) belief within ``reach`` rows and columns of a cell."""

    def __init__(self, belief: Belief, cell: Cell, reach: int) -> None:
        self._top, self._left = (max(0, at - reach) for at in cell)
        self.belief = np.ascontiguousarray(belief[self._top : cell[0] + reach + 1, self._left : cell[1] + reach + 1])
        """The part, (h, w)."""
        self._width = belief.shape[1]

    def flat(self, cells: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return flat cells of the map that are in this part as flat cells of it, (K,)."""
        rows, cols = np.divmod(cells, self._width)
        return np.asarray((rows - self._top) * self.belief.shape[1] + cols - self._left, np.int32)

    def clusters(self, clusters: Clusters) -> Clusters:
        """Return the clusters with their cells in this part alone; some may have none."""
        rows, cols = np.divmod(clusters.cells, self._width)
        height, width = self.belief.shape
        inside = (rows >= self._top) & (rows < self._top + height) & (cols >= self._left) & (cols < self._left + width)
        ends = np.concatenate([[0], np.cumsum(inside)])[clusters.ends]
        return Clusters(self.flat(clusters.cells[inside]), ends)
