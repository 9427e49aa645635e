"""RRT-based frontier detection: trees find the frontiers, a revenue picks one (Umari & Mukhopadhyay 2017)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Cell
from indoor_explorers.env.grid import UNREACHABLE
from indoor_explorers.env.policy import Pilot, Policy
from indoor_explorers.env.view import Briefing, View
from indoor_explorers.planners.gains import unclaimed_gains
from indoor_explorers.planners.goals import GoalPilot
from indoor_explorers.planners.parameters import at_least
from indoor_explorers.planners.paths import frontier_cells
from indoor_explorers.planners.sampling.segments import entries
from indoor_explorers.planners.sampling.trees import grow_tree
from indoor_explorers.planners.teammates import claims

#: How often the samples are doubled when a tree has met no frontier, before the nearest one is searched for.
DOUBLINGS = 2


@dataclass(frozen=True, kw_only=True)
class RrtFrontier(Policy):
    """Grow trees into the unknown and fly to where an edge first met it, at the best revenue.

    The revenue of a candidate is ``gain_weight`` I h / R - d: I the unknown cells visible from it that are not
    near a teammate's claim, h the hysteresis, R the lidar range in cells and d the path length in steps. The paper
    counts I in square metres with an information radius of one metre; dividing by R is the same weight for any
    range and cell size (without it, a long range makes every candidate worth a flight across the map).
    Teammates are told the goal.

    H. Umari, S. Mukhopadhyay, "Autonomous robotic exploration based on multiple rapidly-exploring
    randomized trees", IROS 2017, doi:10.1109/IROS.2017.8202319.
    """

    samples: int = 200
    """Samples for a tree, half of them near the UAV (the paper's local tree), half all over the map."""
    edge: float = 4.0
    """Longest edge of a tree in cells."""
    local_ranges: float = 2.0
    """Half the side of the square that local samples are drawn from, in lidar ranges."""
    merge_distance: float = 3.0
    """Candidates are merged when they are nearer to each other, in cells."""
    gain_weight: float = 3.0
    """Lidar ranges of flight that one squared lidar range of unknown is worth (the paper: 3)."""
    hysteresis: float = 2.0
    """Factor on the gain of candidates near the UAV."""
    hysteresis_radius: float = 3.0
    """How near, in cells."""

    def __post_init__(self) -> None:
        at_least(self, 1, "samples")
        at_least(self, 0.5, "edge", "local_ranges")
        at_least(self, 0.0, "merge_distance", "gain_weight", "hysteresis", "hysteresis_radius")

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the mind of one UAV."""
        return RrtFrontierPilot(briefing, self)


class RrtFrontierPilot(GoalPilot):
    """Keep candidates from tree to tree; drop those that are no frontier any more."""

    def __init__(self, briefing: Briefing, policy: RrtFrontier) -> None:
        super().__init__(briefing)
        self._policy = policy
        self._candidates = np.empty(0, np.int32)
        self._fallbacks = 0

    def choose(self, view: View) -> Cell | None:
        """Return the candidate with the highest revenue, the nearest frontier cell when trees find none."""
        field = self.paths.field(view.belief, view.cell)
        cells = self._detected(view, field)
        if len(cells):
            goal: Cell | None = divmod(int(cells[np.argmax(self._revenue(view, cells, field))]), self.paths.width)
        else:
            self._fallbacks += 1
            path = self.paths.to_frontier(view.belief, view.cell, self.rng, self.avoided(view))
            goal = path[-1] if path else None
        self.message = (float(goal[0]), float(goal[1])) if goal else None
        return goal

    def tally(self) -> dict[str, float]:
        """Return how often the trees had found no frontier, beside the common figures."""
        return super().tally() | {"fallbacks": float(self._fallbacks)}

    def _detected(self, view: View, field: NDArray[np.int32]) -> NDArray[np.int32]:
        """Grow a tree, larger ones while nothing is found, and return (K,) flat cells to choose from."""
        for doubling in range(DOUBLINGS + 1):
            samples = self._draw(view, self._policy.samples << doubling)
            tree = grow_tree(view.belief, (view.cell[0] + 0.5, view.cell[1] + 0.5), samples, self._policy.edge)
            found = np.concatenate([self._candidates, entries(view.belief, *tree)])
            found = np.unique(found[frontier_cells(view.belief, found)])
            found = found[np.argsort(field.ravel()[found], kind="stable")]
            self._candidates = merged(found, self._policy.merge_distance, self.paths.width)
            cells = self._candidates[field.ravel()[self._candidates] < UNREACHABLE]
            cells = cells[~self.shunned(view, cells)]
            if len(cells):
                break
        return cells

    def _draw(self, view: View, count: int) -> NDArray[np.float64]:
        """Draw (count, 2) points, by turns near the UAV and all over the map."""
        size = np.array(view.belief.shape, np.float64)
        points = self.rng.random((count, 2))
        half = self._policy.local_ranges * self.briefing.lidar_range
        low = np.maximum(np.array(view.cell) + 0.5 - half, 0.0)
        high = np.minimum(np.array(view.cell) + 0.5 + half, size)
        points[::2] = low + points[::2] * (high - low)
        points[1::2] *= size
        return points

    def _revenue(self, view: View, cells: NDArray[np.int32], field: NDArray[np.int32]) -> NDArray[np.float64]:
        gains = unclaimed_gains(view.belief, cells, claims(view, self.briefing), self.briefing.lidar_range)
        rows, cols = np.divmod(cells, self.paths.width)
        near = np.hypot(rows - view.cell[0], cols - view.cell[1]) <= self._policy.hysteresis_radius
        weight = self._policy.gain_weight / self.briefing.lidar_range
        worth = weight * gains * np.where(near, self._policy.hysteresis, 1.0)
        return np.asarray(worth - field.ravel()[cells], np.float64)


def merged(cells: NDArray[np.int32], distance: float, width: int) -> NDArray[np.int32]:
    """Return (K,) flat cells without those nearer than ``distance`` cells to one before them that is kept."""
    points = np.stack(np.divmod(cells, width), axis=1)
    kept: list[int] = []
    for k, point in enumerate(points):
        if not kept or (np.hypot(*(points[kept] - point).T) >= distance).all():
            kept.append(k)
    return cells[kept]
