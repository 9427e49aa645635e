"""A pilot that flies to viewpoints: sampled cells from which unknown ones may come into view."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Cell, Distances, Mask
from indoor_explorers.env.grid import UNREACHABLE
from indoor_explorers.env.policy import Policy
from indoor_explorers.env.view import Briefing, View
from indoor_explorers.planners.goals import GoalPilot
from indoor_explorers.planners.parameters import at_least
from indoor_explorers.planners.sampling.views import Promises
from indoor_explorers.planners.teammates import claims, remembered

#: Viewpoints within this share of the lidar range of the goal are taken to be the same goal.
SAME_PLACE = 0.2


class Viewpoints(NamedTuple):
    """K viewpoints to choose from."""

    cells: NDArray[np.int32]
    """(K,) flat cells."""
    steps: Distances
    """(K,) steps from the UAV."""
    promises: NDArray[np.float64]
    """(K,) what they promise, less what is left to the teammates."""

    def those(self, chosen: Mask) -> Viewpoints:
        """Return the viewpoints where (K,) ``chosen`` is True."""
        return Viewpoints(self.cells[chosen], self.steps[chosen], self.promises[chosen])


@dataclass(frozen=True, kw_only=True)
class ViewpointPolicy(Policy):
    """Hold what all planners on viewpoints weigh them by."""

    discount: float = 1.5
    """How fast promises fade with the way to them: by a factor e for this share of a step per lidar range."""
    isolation: float = 8.0
    """What an unknown cell counts more when all of the 24 around it are known."""
    depth: float = 0.5
    """How far away, in lidar ranges, an unknown cell counts less by a factor e."""
    keep: float = 1.2
    """Factor on promises near the goal so far."""
    share: float = 0.5
    """What each teammate that is nearer leaves of a promise."""

    def __post_init__(self) -> None:
        at_least(self, 0.0, "discount", "isolation", "keep", "share")
        at_least(self, 0.01, "depth")


class ViewpointPilot(GoalPilot):
    """Fly to viewpoints that a subclass chooses, and to the nearest frontier cell when it has none.

    A viewpoint is spent when the UAV has been there, for nothing unknown is in view from a cell that it has been in,
    or when it promises nothing any more. So every viewpoint that is reached adds to the map, and when there is none
    left the frontier decides whether there is more to do. The goal is told to the teammates.
    """

    def __init__(self, briefing: Briefing, policy: ViewpointPolicy) -> None:
        super().__init__(briefing)
        self.weights = policy
        self.promises = Promises(briefing.shape, briefing.lidar_range, policy.isolation, policy.depth)
        self._grown = False
        self._fallbacks = 0

    @abstractmethod
    def viewpoint(self, view: View) -> Cell | None:
        """Return the viewpoint to fly to next, none near :meth:`avoided`; None when none promises anything."""

    def learned(self, view: View) -> None:
        """Remember that the map has grown since the last choice."""
        self._grown = True

    def reconsider(self, view: View) -> bool:
        """Weigh the viewpoints again whenever the map has grown."""
        return self._grown

    def spent(self, view: View, goal: Cell) -> bool:
        """Tell whether the UAV has been at its goal or nothing unknown is in view from there any more."""
        return bool(view.visited[goal] or self.promises.of(view.belief, self.paths.flat([goal]))[0] <= 0.0)

    def choose(self, view: View) -> Cell | None:
        """Return the viewpoint that the subclass wants, else the nearest frontier cell."""
        self._grown = False
        goal = self.viewpoint(view)
        if goal is None:
            self._fallbacks += 1
            path = self.paths.to_frontier(view.belief, view.cell, self.rng, self.avoided(view))
            goal = path[-1] if path else None
        self.message = (float(goal[0]), float(goal[1])) if goal else None
        return goal

    def tally(self) -> dict[str, float]:
        """Return how often no viewpoint promised anything, beside the common figures."""
        return super().tally() | {"fallbacks": float(self._fallbacks)}

    def judged(self, view: View, cells: NDArray[np.int32]) -> Viewpoints:
        """Return those of (K,) flat cells that can be reached, are not left alone for now and promise something.

        A teammate that is nearer, or as near and of a lower number, leaves a share of a promise; its claim leaves
        nothing where it is, and more with the distance, up to a lidar range.
        """
        field = self.paths.field(view.belief, view.cell)
        cells = cells[(field.ravel()[cells] < UNREACHABLE) & ~view.visited.ravel()[cells]]
        cells = cells[~self.shunned(view, cells)]
        steps, promises = field.ravel()[cells], self.promises.of(view.belief, cells)
        promises = promises * self._left(view, cells, steps)
        return Viewpoints(cells, steps, promises).those(promises > 0.0)

    def best(self, viewpoints: Viewpoints) -> Cell | None:
        """Return the viewpoint with the highest discounted promise, preferring those near the goal so far."""
        if not len(viewpoints.cells):
            return None
        lidar_range = self.briefing.lidar_range
        scores = viewpoints.promises * np.exp(-self.weights.discount / lidar_range * viewpoints.steps)
        if self.goal is not None:
            rows, cols = np.divmod(viewpoints.cells, self.paths.width)
            away = np.maximum(np.abs(rows - self.goal[0]), np.abs(cols - self.goal[1]))
            scores[away <= max(1.0, SAME_PLACE * lidar_range)] *= self.weights.keep
        return divmod(int(viewpoints.cells[np.argmax(scores)]), self.paths.width)

    def _left(self, view: View, cells: NDArray[np.int32], steps: Distances) -> NDArray[np.float64]:
        """Return which share of the promises the teammates leave, (K,)."""
        left = np.ones(len(cells))
        if not view.mates:
            return left
        for mate in remembered(view, self.briefing):
            theirs = self.paths.field(view.belief, mate.cell).ravel()[cells]
            nearer = (theirs <= steps) if mate.agent < self.briefing.agent else (theirs < steps)
            left *= np.where(nearer, self.weights.share, 1.0)
        rows, cols = np.divmod(cells, self.paths.width)
        for row, col in claims(view, self.briefing).tolist():
            left *= np.minimum(1.0, np.hypot(rows - row, cols - col) / self.briefing.lidar_range)
        return left
