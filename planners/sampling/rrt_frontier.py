"""RRT-based frontier detection: trees find the frontiers, a revenue picks one (Umari & Mukhopadhyay 2017)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Cell
from indoor_explorers.env.compiled import kernel
from indoor_explorers.env.grid import FREE, UNKNOWN, UNREACHABLE
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

    As in the paper a local tree, which finds the corners that the UAV is about to leave behind, and a global one
    feed one list of candidates. They start afresh each time, for the map has changed under them.

    The revenue of a candidate is ``gain_weight`` I h / R - d: I the unknown cells visible from it that are not
    near a teammate's claim, h the hysteresis, R the lidar range in cells and d the path length in steps. The paper
    counts I in square metres with an information radius of one metre; dividing by R is the same weight for any
    range and cell size (without it, a long range makes every candidate worth a flight across the map).
    Teammates are told the goal.

    H. Umari, S. Mukhopadhyay, "Autonomous robotic exploration based on multiple rapidly-exploring
    randomized trees", IROS 2017, doi:10.1109/IROS.2017.8202319.
    """

    local_samples: int = 150
    """Samples for the local tree, grown near the UAV whenever the map has."""
    global_samples: int = 150
    """Samples for the global tree, grown all over the map when a goal is chosen."""
    bias: float = 0.5
    """Share of the samples drawn from unknown cells next to known free ones; the others are drawn anywhere."""
    edge: float = 4.0
    """Longest edge of a tree in cells."""
    local_ranges: float = 1.0
    """Half the side of the square around the UAV that the local tree stays in, in lidar ranges."""
    merge_distance: float = 3.0
    """Candidates are merged when they are nearer to each other, in cells."""
    gain_weight: float = 3.0
    """Lidar ranges of flight that one squared lidar range of unknown is worth (the paper: 3)."""
    hysteresis: float = 2.0
    """Factor on the gain of candidates near the UAV."""
    hysteresis_radius: float = 3.0
    """How near, in cells."""

    def __post_init__(self) -> None:
        at_least(self, 1, "local_samples", "global_samples")
        at_least(self, 0.5, "edge", "local_ranges")
        at_least(self, 0.0, "bias", "merge_distance", "gain_weight", "hysteresis", "hysteresis_radius")

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

    def learned(self, view: View) -> None:
        """Grow a local tree and add what it finds to the candidates."""
        half = self._policy.local_ranges * self.briefing.lidar_range
        centre, size = np.array(view.cell) + 0.5, np.array(view.belief.shape, np.float64)
        self._grow(view, np.maximum(centre - half, 0.0), np.minimum(centre + half, size), self._policy.local_samples)

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
        """Grow a global tree, larger ones while nothing is found, and return (K,) flat cells to choose from."""
        size = np.array(view.belief.shape, np.float64)
        for doubling in range(DOUBLINGS + 1):
            self._grow(view, np.zeros(2), size, self._policy.global_samples << doubling)
            found = self._candidates[field.ravel()[self._candidates] < UNREACHABLE]
            found = found[~self.shunned(view, found)]
            if len(found):
                break
        nearest_first = found[np.argsort(field.ravel()[found], kind="stable")]
        return merged(nearest_first, self._policy.merge_distance, self.paths.width)

    def _grow(self, view: View, low: NDArray[np.float64], high: NDArray[np.float64], samples: int) -> None:
        """Grow a tree from the UAV to samples between two corners; bring the candidates up to date."""
        points = low + self.rng.random((samples, 2)) * (high - low)
        edge_of_unknown = border_cells(view.belief, low.astype(np.int64), np.ceil(high).astype(np.int64))
        if len(edge_of_unknown):
            biased = min(samples, int(self._policy.bias * samples))
            drawn = edge_of_unknown[self.rng.integers(len(edge_of_unknown), size=biased)]
            points[:biased] = drawn + self.rng.random((biased, 2))
            points = self.rng.permutation(points)
        tree = grow_tree(view.belief, (view.cell[0] + 0.5, view.cell[1] + 0.5), points, self._policy.edge)
        found = np.union1d(self._candidates, entries(view.belief, *tree))
        self._candidates = found[frontier_cells(view.belief, found)]

    def _revenue(self, view: View, cells: NDArray[np.int32], field: NDArray[np.int32]) -> NDArray[np.float64]:
        gains = unclaimed_gains(view.belief, cells, claims(view, self.briefing), self.briefing.lidar_range)
        rows, cols = np.divmod(cells, self.paths.width)
        near = np.hypot(rows - view.cell[0], cols - view.cell[1]) <= self._policy.hysteresis_radius
        weight = self._policy.gain_weight / self.briefing.lidar_range
        worth = weight * gains * np.where(near, self._policy.hysteresis, 1.0)
        return np.asarray(worth - field.ravel()[cells], np.float64)


@kernel()
def merged(cells: np.ndarray, distance: float, width: int) -> np.ndarray:
    """Return (K,) flat cells without those nearer than ``distance`` cells to one before them that is kept."""
    kept = np.empty(cells.shape[0], np.int32)
    size = 0
    for cell in cells:
        row, col = divmod(cell, width)
        apart = True
        for k in range(size):
            rows, cols = row - kept[k] // width, col - kept[k] % width
            apart &= rows * rows + cols * cols >= distance * distance
        if apart:
            kept[size] = cell
            size += 1
    return kept[:size]


@kernel()
def border_cells(belief: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the unknown cells 4-adjacent to known free ones between two corners, (K, 2) rows and columns."""
    height, width = belief.shape
    found = np.empty(((high[0] - low[0]) * (high[1] - low[1]), 2), np.int64)
    size = 0
    for row in range(low[0], high[0]):
        for col in range(low[1], high[1]):
            if belief[row, col] == UNKNOWN and (
                (row > 0 and belief[row - 1, col] == FREE)
                or (col > 0 and belief[row, col - 1] == FREE)
                or (row + 1 < height and belief[row + 1, col] == FREE)
                or (col + 1 < width and belief[row, col + 1] == FREE)
            ):
                found[size] = row, col
                size += 1
    return found[:size]
