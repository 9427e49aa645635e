"""A pilot that flies to viewpoints: sampled cells with unknown cells in view."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell, Distances, Mask
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.policy import ALL_CELLS, Policy
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.sensing.lidar import LidarModel
from indoor_explorers.planners.sampling.covers import distinct
from indoor_explorers.planners.sampling.points import distances_to
from indoor_explorers.planners.sampling.samples import merged
from indoor_explorers.planners.toolbox.coordination.out_of_contact import OutOfContact
from indoor_explorers.planners.toolbox.information.candidates import distances_between
from indoor_explorers.planners.toolbox.information.view_gain import WeightedGains, visible_sets
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.teammates import linked, message_of, sent_goal
from indoor_explorers.planners.toolbox.parameters import (
    DiscountParameters,
    GainParameters,
    SwitchCostParameters,
    bounded,
)
from indoor_explorers.planners.toolbox.routing.min_latency import best_orders

#: Distance, as a share of the lidar range, within which a viewpoint counts as the current goal.
SAME_PLACE = 0.2
#: Most viewpoints in an order, and the number of best ones that they are selected from.
STOPS, CANDIDATES = 12, 48
#: Smallest distance between them, in cells or in lidar ranges, whichever is more,
APART_CELLS, APART_RANGES = 1.5, 0.15
#: and largest share of a view that it may have in common with a better one's.
OVERLAP = 0.3
#: Paths between them are searched up to this length in lidar ranges; longer ones are bounded by the UAV's position.
HOP_RANGES = 3.0
#: Viewpoints whose factor for teammates is less than this share of the largest factor are left to the teammates.
LEFT_TO_OTHERS = 0.3


class Viewpoints(NamedTuple):
    """K viewpoints to choose from."""

    cells: NDArray[np.int32]
    """(K,) flat cells."""
    steps: Distances
    """(K,) steps from the UAV."""
    gains: NDArray[np.float64]
    """(K,) weighted view gains, times the factors for teammates."""
    left: NDArray[np.float64]
    """(K,) factors for teammates."""

    def selected(self, chosen: Mask | NDArray[np.int64]) -> Viewpoints:
        """Return the viewpoints that ``chosen`` selects, a (K,) mask or indices."""
        return Viewpoints(self.cells[chosen], self.steps[chosen], self.gains[chosen], self.left[chosen])

    def unclaimed(self) -> Viewpoints:
        """Return the viewpoints that are not left to teammates."""
        return self.selected(self.left > LEFT_TO_OTHERS * self.left.max(initial=0.0))


def diverse_subset(
    belief: Belief,
    cells: NDArray[np.int32],
    scores: NDArray[np.float64],
    lidar: LidarModel,
    tried: int,
    most: int,
    rise: int = 0,
) -> NDArray[np.int64]:
    """Return the indices of the best of (K,) flat cells by their scores that are apart and have different views.

    At most ``most`` of the best ``tried`` that are apart, the best first.
    """
    order = np.argsort(-scores, kind="stable")
    apart = max(APART_CELLS, APART_RANGES * lidar.range)
    order = order[merged(cells[order], apart, belief.shape[1], tried, rise)]
    return np.asarray(order[distinct(visible_sets(belief, cells[order], lidar), OVERLAP, most)])


@renamed(discount="discount_rate", depth="decay_length", hold="switch_cost")
@dataclass(frozen=True, kw_only=True)
class ViewpointPolicy(GainParameters, DiscountParameters, SwitchCostParameters, Policy):
    """Parameters of all planners on viewpoints."""

    plans_for: ClassVar[str] = ALL_CELLS

    discount_rate: float = 1.5
    share: float = bounded(0.5, least=0, tunable=(0.1, 1.0))
    """Factor on a gain for each closer teammate."""


class ViewpointPilot(GoalPilot):
    """Fly to viewpoints that a subclass chooses, and to the nearest frontier cell when it has none.

    A viewpoint is dropped when the UAV has been there, since it then has no unknown cells in view, or when its gain is
    0. So every viewpoint that is reached adds to the map, and without viewpoints the UAV explores the frontier. The
    goal is sent to the teammates.
    """

    changes_levels: ClassVar[bool] = True
    straight = True
    replan_period: float = 0

    def __init__(self, briefing: Briefing, policy: ViewpointPolicy) -> None:
        super().__init__(briefing)
        self.weights = policy
        self.gains = WeightedGains(briefing.shape, self.lidar, policy.decay_length, policy.isolation)
        self._out_of_contact = OutOfContact(briefing)
        self._fallbacks = 0

    @property
    def axes(self) -> int:
        """Number of coordinates of a point: 2, or 3 on maps of several levels."""
        return 3 if self.paths.rise > 0 else 2

    @property
    def largest_view(self) -> float:
        """Cells that a scan can show at most: the area of the lidar's disc, or all cells in range over levels."""
        return float(self.lidar.disc) if self.paths.rise > 0 else np.pi * self.briefing.lidar_range**2

    @abstractmethod
    def viewpoint(self, view: View) -> Cell | None:
        """Return the viewpoint to fly to next, except :meth:`near_banned` ones; None if none has a gain."""

    def is_spent(self, view: View, goal: Cell) -> bool:
        """Tell whether the UAV has been at its goal, or the goal has no unknown cells in view any more."""
        return bool(view.visited[goal] or self.gains.at(view.belief, self.paths.flat([goal]))[0] <= 0.0)

    def choose(self, view: View) -> Cell | None:
        """Return the viewpoint that the subclass chooses, or else the nearest frontier cell."""
        goal = self.viewpoint(view)
        if goal is None:
            self._fallbacks += 1
            goal = self.nearest_frontier(view)
        self.message = message_of(goal)
        return goal

    def tally(self) -> dict[str, float]:
        """Return also the number of choices without any viewpoint that has a gain."""
        return super().tally() | {"fallbacks": float(self._fallbacks)}

    def judged(self, view: View, cells: NDArray[np.int32]) -> Viewpoints:
        """Return the viewpoints among (K,) flat cells: reachable, not banned, and with a gain."""
        field = self.steps_from(view, view.cell)
        cells = cells[(field.ravel()[cells] < UNREACHABLE) & ~view.visited.ravel()[cells]]
        cells = cells[~self.near_banned(view, cells)]
        steps, gains = field.ravel()[cells], self.gains.at(view.belief, cells)
        left = self._left(view, cells, steps)
        return Viewpoints(cells, steps, gains * left, left).selected(gains * left > 0.0)

    def best(self, view: View, viewpoints: Viewpoints, latency: float) -> Cell | None:
        """Return the first viewpoint of the order of lowest cost through the best ones.

        The cost of an order, in lidar ranges, is the time at which its last viewpoint is reached, plus ``latency``
        times the mean waiting time weighted by the roots of the gains: pockets are finished while the UAV is near.
        """
        viewpoints = viewpoints.unclaimed()
        if not len(viewpoints.cells):
            return None
        some = viewpoints.selected(self._diverse(view, viewpoints))
        costs = self._costs(view, some, latency) - self.weights.switch_cost * self._kept(some.cells)
        self.consider(
            some.cells, "cost of the best order, negative", -costs, cost=costs, gain=some.gains, steps=some.steps
        )
        return divmod(int(some.cells[np.argmin(costs)]), self.paths.width)

    def _diverse(self, view: View, viewpoints: Viewpoints) -> NDArray[np.int64]:
        """Return the indices of the best of (K,) viewpoints that are apart and have different views."""
        reach = self.briefing.lidar_range
        scores = np.log(viewpoints.gains) - self.weights.discount_rate * viewpoints.steps / reach
        scores += self.weights.switch_cost * self._kept(viewpoints.cells)
        return diverse_subset(view.belief, viewpoints.cells, scores, self.lidar, CANDIDATES, STOPS, self.paths.rise)

    def _costs(self, view: View, viewpoints: Viewpoints, latency: float) -> NDArray[np.float64]:
        """Return, for each of (K,) viewpoints, the cost of the best order that begins there, in lidar ranges, (K,)."""
        if len(viewpoints.cells) == 1:
            return np.zeros(1)
        reach, steps = self.briefing.lidar_range, viewpoints.steps.astype(np.float64)
        limit = int(HOP_RANGES * reach) + 1
        between = distances_between(view.belief, viewpoints.cells, steps[None], limit, self.paths.rise)
        worth = np.sqrt(viewpoints.gains)
        return best_orders(steps / reach, between / reach, worth / worth.sum(), latency)[0]

    def _kept(self, cells: NDArray[np.int32]) -> Mask:
        """Return which of (K,) flat cells are at the current goal, (K,) bool."""
        radius = max(1.0, SAME_PLACE * self.briefing.lidar_range)
        return self.near_goal(self.goal, cells, radius, np.maximum)

    def _left(self, view: View, cells: NDArray[np.int32], steps: Distances) -> NDArray[np.float64]:
        """Return the factors on the gains for teammates, (K,) in [0, 1].

        A linked teammate that is closer, or as close and of a lower number, has the factor ``share``; its goal has a
        factor of 0 in its own cell, which rises to 1 at a lidar range. The other factors are those of teammates out of
        contact.
        """
        if self.briefing.team == 1:
            return np.ones(len(cells))
        left = self._out_of_contact.at_cells(view, cells, steps, self.steps_from)
        for mate in linked(view):
            theirs = self.steps_from(view, mate.cell).ravel()[cells]
            nearer = (theirs <= steps) if mate.agent < self.briefing.agent else (theirs < steps)
            left *= np.where(nearer, self.weights.share, 1.0)
            goal = sent_goal(mate)
            if goal is not None:
                away = distances_to(cells, goal, self.paths.width, self.paths.rise)
                left *= np.minimum(1.0, away / self.briefing.lidar_range)
        return left
