"""A pilot that flies to viewpoints: sampled cells from which unknown ones may come into view."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell, Distances, Mask
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.policy import Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.coordination.out_of_contact import OutOfContact
from indoor_explorers.planners.coordination.teammates import linked, message_of, told_goal
from indoor_explorers.planners.information.candidates import distances_between
from indoor_explorers.planners.information.view_gain import WeightedGains, visible_sets
from indoor_explorers.planners.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.parameters import at_least
from indoor_explorers.planners.routing.min_latency import costs_of_first
from indoor_explorers.planners.sampling.covers import distinct
from indoor_explorers.planners.sampling.samples import merged

#: Viewpoints within this share of the lidar range of the goal count as that goal.
SAME_PLACE = 0.2
#: The most viewpoints of an order, and the most with the best scores that they are taken from.
STOPS, CANDIDATES = 12, 48
#: They are at least this far apart, in cells or in lidar ranges, whichever is more,
APART_CELLS, APART_RANGES = 1.5, 0.15
#: and each has at most this share of its view in common with a better one.
OVERLAP = 0.3
#: Paths between them are measured up to this many lidar ranges; beyond this, through the UAV's position.
HOP_RANGES = 3.0
#: Viewpoints of which teammates leave less than this share of the most that they leave of any are theirs.
LEFT_TO_OTHERS = 0.3


class Viewpoints(NamedTuple):
    """K viewpoints to choose from."""

    cells: NDArray[np.int32]
    """(K,) flat cells."""
    steps: Distances
    """(K,) steps from the UAV."""
    gains: NDArray[np.float64]
    """(K,) their weighted view gains, less what is left to the teammates."""
    left: NDArray[np.float64]
    """(K,) the share of the gains that the teammates leave."""

    def those(self, chosen: Mask | NDArray[np.int64]) -> Viewpoints:
        """Return the viewpoints where (K,) ``chosen`` is True, or those it numbers."""
        return Viewpoints(self.cells[chosen], self.steps[chosen], self.gains[chosen], self.left[chosen])

    def unclaimed(self) -> Viewpoints:
        """Return those that the teammates do not leave much less of than of others."""
        return self.those(self.left > LEFT_TO_OTHERS * self.left.max(initial=0.0))


def few(
    belief: Belief, cells: NDArray[np.int32], scores: NDArray[np.float64], lidar_range: float, tried: int, most: int
) -> NDArray[np.int64]:
    """Return the places of the best of (K,) flat cells by their scores that are apart and see different things.

    At most ``most`` of the best ``tried`` that are apart, the best first.
    """
    order = np.argsort(-scores, kind="stable")
    apart = max(APART_CELLS, APART_RANGES * lidar_range)
    order = order[merged(cells[order], apart, belief.shape[1], tried)]
    return np.asarray(order[distinct(visible_sets(belief, cells[order], lidar_range), OVERLAP, most)])


@dataclass(frozen=True, kw_only=True)
class ViewpointPolicy(Policy):
    """Hold what all planners on viewpoints weigh them by."""

    discount: float = 1.5
    """Discount rate: a viewpoint's gain counts gain * exp(-discount * path_length / lidar_range)."""
    isolation: float = 8.0
    """What an unknown cell counts more when all of the 24 around it are known."""
    depth: float = 0.5
    """How far away, in lidar ranges, an unknown cell counts less by a factor e."""
    hold: float = 0.2
    """What a goal elsewhere than the one so far has to save, in lidar ranges."""
    share: float = 0.5
    """Share of a gain that each nearer teammate leaves."""

    def __post_init__(self) -> None:
        at_least(self, 0.0, "discount", "isolation", "hold", "share")
        at_least(self, 0.01, "depth")


class ViewpointPilot(GoalPilot):
    """Fly to viewpoints that a subclass chooses, and to the nearest frontier cell when it has none.

    A viewpoint is spent when the UAV has been there, for nothing unknown is in view from a cell that it has been in,
    or when its gain is 0. So every viewpoint that is reached adds to the map, and when there is none
    left the frontier decides whether there is more to do. The goal is told to the teammates.
    """

    straight = True

    def __init__(self, briefing: Briefing, policy: ViewpointPolicy) -> None:
        super().__init__(briefing)
        self.weights = policy
        self.gains = WeightedGains(briefing.shape, briefing.lidar_range, policy.depth, policy.isolation)
        self._out_of_contact = OutOfContact(briefing)
        self._grown = False
        self._fallbacks = 0

    @abstractmethod
    def viewpoint(self, view: View) -> Cell | None:
        """Return the viewpoint to fly to next, no :meth:`near_banned` one; None when none has a gain."""

    def on_map_growth(self, view: View) -> None:
        """Remember that the map has grown since the last choice."""
        self._grown = True

    def wants_replan(self, view: View) -> bool:
        """Weigh the viewpoints again whenever the map has grown."""
        return self._grown

    def is_spent(self, view: View, goal: Cell) -> bool:
        """Tell whether the UAV has been at its goal or nothing unknown is in view from there any more."""
        return bool(view.visited[goal] or self.gains.at(view.belief, self.paths.flat([goal]))[0] <= 0.0)

    def choose(self, view: View) -> Cell | None:
        """Return the viewpoint that the subclass wants, else the nearest frontier cell."""
        self._grown = False
        goal = self.viewpoint(view)
        if goal is None:
            self._fallbacks += 1
            goal = self.nearest_frontier(view)
        self.message = message_of(goal)
        return goal

    def tally(self) -> dict[str, float]:
        """Return how often no viewpoint had a gain, beside the common figures."""
        return super().tally() | {"fallbacks": float(self._fallbacks)}

    def judged(self, view: View, cells: NDArray[np.int32]) -> Viewpoints:
        """Return those of (K,) flat cells that can be reached, are not banned for now and have a gain."""
        field = self.steps_from(view, view.cell)
        cells = cells[(field.ravel()[cells] < UNREACHABLE) & ~view.visited.ravel()[cells]]
        cells = cells[~self.near_banned(view, cells)]
        steps, gains = field.ravel()[cells], self.gains.at(view.belief, cells)
        left = self._left(view, cells, steps)
        return Viewpoints(cells, steps, gains * left, left).those(gains * left > 0.0)

    def best(self, view: View, viewpoints: Viewpoints, latency: float) -> Cell | None:
        """Return the viewpoint with which the cheapest order of the best ones begins.

        An order costs, in lidar ranges, when its last viewpoint is reached plus ``latency`` times their mean waiting
        time, weighted by the roots of their gains: pockets are finished while the UAV is near.
        """
        viewpoints = viewpoints.unclaimed()
        if not len(viewpoints.cells):
            return None
        some = viewpoints.those(self._few(view, viewpoints))
        costs = self._costs(view, some, latency) - self.weights.hold * self._kept(some.cells)
        return divmod(int(some.cells[np.argmin(costs)]), self.paths.width)

    def _few(self, view: View, viewpoints: Viewpoints) -> NDArray[np.int64]:
        """Return the places of the best of (K,) viewpoints that are apart and see different things."""
        reach = self.briefing.lidar_range
        scores = np.log(viewpoints.gains) - self.weights.discount * viewpoints.steps / reach
        scores += self.weights.hold * self._kept(viewpoints.cells)
        return few(view.belief, viewpoints.cells, scores, reach, CANDIDATES, STOPS)

    def _costs(self, view: View, viewpoints: Viewpoints, latency: float) -> NDArray[np.float64]:
        """Return what the best order costs that begins with each of (K,) viewpoints, in lidar ranges, (K,)."""
        if len(viewpoints.cells) == 1:
            return np.zeros(1)
        reach, steps = self.briefing.lidar_range, viewpoints.steps.astype(np.float64)
        between = distances_between(view.belief, viewpoints.cells, steps[None], int(HOP_RANGES * reach) + 1)
        worth = np.sqrt(viewpoints.gains)
        return np.asarray(costs_of_first(steps / reach, between / reach, worth / worth.sum(), latency))

    def _kept(self, cells: NDArray[np.int32]) -> Mask:
        """Return which of (K,) flat cells are at the goal so far, (K,) bool."""
        if self.goal is None:
            return np.zeros(len(cells), np.bool_)
        rows, cols = np.divmod(cells, self.paths.width)
        away = np.maximum(np.abs(rows - self.goal[0]), np.abs(cols - self.goal[1]))
        return np.asarray(away <= max(1.0, SAME_PLACE * self.briefing.lidar_range))

    def _left(self, view: View, cells: NDArray[np.int32], steps: Distances) -> NDArray[np.float64]:
        """Return which share of the gains the teammates leave, (K,) in [0, 1].

        A linked one that is nearer, or as near and of a lower number, leaves a share; its claim leaves nothing where
        it is, and more with the distance, up to a lidar range. The others are out of contact.
        """
        if self.briefing.team == 1:
            return np.ones(len(cells))

        def steps_from(cell: Cell) -> Distances:
            return self.steps_from(view, cell).ravel()[cells]

        rows, cols = np.divmod(cells, self.paths.width)
        left = self._out_of_contact.factors(view, np.stack([rows, cols], axis=1).astype(np.float64), steps, steps_from)
        for mate in linked(view):
            theirs = steps_from(mate.cell)
            nearer = (theirs <= steps) if mate.agent < self.briefing.agent else (theirs < steps)
            left *= np.where(nearer, self.weights.share, 1.0)
            goal = told_goal(mate)
            if goal is not None:
                left *= np.minimum(1.0, np.hypot(rows - goal[0], cols - goal[1]) / self.briefing.lidar_range)
        return left
