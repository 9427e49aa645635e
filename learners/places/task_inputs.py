"""What a network of places sees of a harder task: where teammates fly, a narrow view, what errs and what fails."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.policies.view import Mate, View
from indoor_explorers.env.sensing.field_of_view import ALL_AROUND, least_cosine
from indoor_explorers.env.sensing.lidar import LidarModel, new_scan, unknown_in_view
from indoor_explorers.planners.toolbox.navigation.camera_moves import unknown_ahead
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.teammates import linked, sent_goal

#: Numbers about each place, and about the whole task.
TASK_PLACE: Final = 5
TASK_COMMON: Final = 9
#: Farthest way in lidar ranges; larger ones count as this.
_FARTHEST = 10.0

Numbers = NDArray[np.float64]


@kernel()
def _ends_of_paths(steps: np.ndarray, cells: np.ndarray, reach: int) -> np.ndarray:
    """Return the directions in which shortest paths to (K,) flat cells leave the UAV and arrive, (K, 2, 2) int64.

    ``steps`` (H, W) are those from the UAV's cell. Directions are rows and columns over the first and the last
    ``reach`` steps of a path that turns as late as it can, seen from its end.
    """
    height, width = steps.shape
    ends = np.zeros((cells.shape[0], 2, 2), np.int64)
    for k in range(cells.shape[0]):
        row, col = divmod(cells[k], width)
        length, move = steps[row, col], 0
        first_row, first_col = row, col
        for left in range(length, 0, -1):
            if left == length - reach:
                ends[k, 1, 0], ends[k, 1, 1] = cells[k] // width - row, cells[k] % width - col
            if left == min(reach, length):
                first_row, first_col = row, col
            for turn in range(4):
                down, right = MOVES[(move + turn) % 4, 0], MOVES[(move + turn) % 4, 1]
                r, c = row + down, col + right
                if 0 <= r < height and 0 <= c < width and steps[r, c] == left - 1:
                    row, col, move = r, c, (move + turn) % 4
                    break
        ends[k, 0, 0], ends[k, 0, 1] = first_row - row, first_col - col
        if length <= reach:
            ends[k, 1] = ends[k, 0]
    return ends


@kernel()
def _shares_in_view(
    belief: np.ndarray, cells: np.ndarray, moves: np.ndarray, lidar: LidarModel, cosine: float
) -> np.ndarray:
    """Return the share of the unknown cells in range of (K,) flat cells that a sensor sees that faces (K,) moves."""
    width = belief.shape[1]
    scan = new_scan(lidar)
    shares = np.ones(cells.shape[0])
    for k in range(cells.shape[0]):
        row, col = divmod(cells[k], width)
        unknown = unknown_in_view(belief, row, col, lidar, scan)
        if unknown:
            shares[k] = unknown_ahead(belief, row, col, moves[k], lidar, scan, cosine) / unknown
    return shares


class TaskInputs:
    """Observe what is harder than a single UAV with an exact sensor, for the choice of one UAV."""

    def __init__(self, pilot: GoalPilot) -> None:
        self._pilot, self._briefing = pilot, pilot.briefing
        self._range = float(pilot.briefing.lidar_range)
        self._cosine = least_cosine(pilot.briefing.scenario.lidar.field_of_view)

    def of_places(self, view: View, cells: NDArray[np.int32], steps: Numbers, mates: Sequence[Mate]) -> list[Numbers]:
        """Return the ``TASK_PLACE`` columns (K,) of places in ``cells``, ``steps`` (K,) lidar ranges away.

        They are how near the nearest goal of a teammate is, by how much nearer than the UAV, and how many goals are
        nearer; the cosine of the angle between the UAV's heading and the way there, and the share of the unknown cells
        around the place that a sensor sees on arrival.
        """
        own, claimed = np.minimum(steps, _FARTHEST) / 5.0, np.full(len(cells), _FARTHEST / 5.0)
        goals = [goal for mate in mates if (goal := sent_goal(mate)) is not None]
        nearer = np.zeros(len(cells))
        for goal in goals:
            theirs = np.minimum(self._pilot.steps_from(view, goal).ravel()[cells] / self._range, _FARTHEST) / 5.0
            claimed = np.minimum(claimed, theirs)
            nearer += theirs < own
        return [claimed, claimed - own, nearer / 4.0, *self._turns(view, cells)]

    def _turns(self, view: View, cells: NDArray[np.int32]) -> list[Numbers]:
        if view.heading is None:
            return [np.zeros(len(cells)), np.ones(len(cells))]
        field = self._pilot.steps_from(view, view.cell)
        ends = _ends_of_paths(field, cells, max(1, int(self._range / 2)))
        away = ends[:, 0].astype(np.float64)
        ahead = (away @ MOVES[view.heading]) / np.maximum(np.hypot(away[:, 0], away[:, 1]), 1.0)
        arrival = np.argmax(ends[:, 1] @ MOVES[:4].T, axis=1)
        return [ahead, _shares_in_view(view.belief, cells, arrival, self._pilot.lidar, self._cosine)]

    def common(self, view: View, mates: Sequence[Mate]) -> list[float]:
        """Return the ``TASK_COMMON`` numbers about the task.

        They are the field of view, the standard deviation of the pose, the rates of slips, misses, errors of ranges,
        stops and radio failures, the share of teammates that are out of contact, and how many seem to have stopped.
        ``mates`` are those that the UAV reckons with.
        """
        scenario, others = self._briefing.scenario, self._briefing.team - 1
        failures, noise = scenario.failures, scenario.noise
        return [
            scenario.lidar.field_of_view / ALL_AROUND,
            min(view.pose_std, 3.0),
            min(500.0 * scenario.drift.rate, 3.0),
            min(5.0 * noise.misses, 3.0),
            min(noise.range_std, 3.0),
            min(500.0 * failures.hazard, 3.0),
            min(50.0 * failures.radio_hazard, 3.0),
            1.0 - len(linked(view)) / others if others else 0.0,
            min((len(view.mates) - len(mates)) / 4.0, 2.0),
        ]
