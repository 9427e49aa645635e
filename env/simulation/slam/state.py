"""Additional state of worlds with sensor noise or drift.

Axes as in :mod:`indoor_explorers.env.simulation.state`; K = N + 1 map holders, the agents and the team, and one more
with a home base; T scans of one agent, one for each step and one for the start.
"""

from __future__ import annotations

from math import cos, radians
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.scenarios.scenario import LEAST_BUDGET, Scenario
from indoor_explorers.env.sensing.lidar import LidarModel
from indoor_explorers.env.simulation.engine import Work
from indoor_explorers.env.simulation.state import Rules, State

#: Field of view without a limit.
ALL_AROUND = 360.0


class ErrorRules(NamedTuple):
    """A scenario's errors as numbers for compiled code."""

    misses: float
    false_returns: float
    range_std: float
    least_cosine: float
    """Of the angle between the heading and what is in the field of view; under -1 for all around."""
    drift: float
    closures: float
    closure_gap: int
    mates: bool


class Slam(NamedTuple):
    """Scans, estimated poses and maps of a batch of episodes."""

    log_odds: NDArray[np.float32]
    """(B, K, H, W) that a cell is occupied: the sum of all readings that the holder has of it; 0 for none."""
    drawn_at: NDArray[np.int32]
    """(B, K, N, T) flat cell from which a holder's map has the scan of an agent; -1 for a scan that it has not."""
    scans: NDArray[np.int64]
    """(B, K, N) scans of each agent that a holder has."""
    revision: NDArray[np.int64]
    """(B, K, N) corrections of each agent's path that a holder has."""
    true_cell: NDArray[np.int32]
    """(B, N, T) flat cell in which a scan was made."""
    heading: NDArray[np.int8]
    """(B, N, T) action whose direction the agent faced in a scan."""
    bump: NDArray[np.int8]
    """(B, N, T) action that ended in an obstacle right before a scan; -1 for none."""
    way: NDArray[np.int32]
    """(B, N, T) cells flown before a scan."""
    variance: NDArray[np.float32]
    """(B, N, T) expected squared error of the pose of a scan, in cells^2."""
    first_visit: NDArray[np.int32]
    """(B, N, H, W) first scan that an agent made in a cell; -1 for none."""
    listed: NDArray[np.bool_]
    """(B, N, H, W) cells in the discovery log."""
    shown_free: NDArray[np.int64]
    """(B, N) flat cell that an agent's map shows as free since it believes to be there."""
    noise_key: NDArray[np.uint64]
    """(B,) key of the stream of the lidar's errors."""
    drift_key: NDArray[np.uint64]
    """(B,) key of the stream of the drift."""
    pose_error: NDArray[np.float64]
    """(B, N) sum over the steps flown of the distance between the believed and the true cell."""


class Readings(NamedTuple):
    """Working arrays of a scan with errors, not to be shared between threads."""

    cells: NDArray[np.int64]
    """Flat cells that were read, as seen from the true cell."""
    values: NDArray[np.float32]
    """Log-odds of each."""
    place: NDArray[np.int32]
    """(H * W,) index + 1 of a cell in ``cells``; 0 between scans."""
    occupancy: NDArray[np.uint8]
    """(H, W) what the lidar takes for the map in one scan."""


class Parts(NamedTuple):
    """All that the compiled functions of a step with errors read and write."""

    rules: Rules
    errors: ErrorRules
    state: State
    slam: Slam
    lidar: LidarModel
    work: Work
    readings: Readings


def error_rules_of(scenario: Scenario) -> ErrorRules:
    """Translate a scenario."""
    view = scenario.lidar.field_of_view
    return ErrorRules(
        misses=scenario.noise.misses,
        false_returns=scenario.noise.false_returns,
        range_std=scenario.noise.range_std,
        least_cosine=-2.0 if view >= ALL_AROUND else cos(radians(view / 2)) - 1e-9,
        drift=scenario.drift.rate,
        closures=scenario.drift.closures,
        closure_gap=scenario.drift.closure_gap,
        mates=scenario.drift.mates,
    )


def empty_slam(scenario: Scenario, batch: int, shape: tuple[int, int]) -> Slam:
    """Allocate what ``batch`` episodes on (H, W) maps hold."""
    b, n, (h, w) = batch, scenario.team, shape
    k = n + 1 + scenario.base.exists
    t = 1 + (scenario.budget or max(LEAST_BUDGET, h * w))
    return Slam(
        log_odds=np.zeros((b, k, h, w), np.float32),
        drawn_at=np.zeros((b, k, n, t), np.int32),
        scans=np.zeros((b, k, n), np.int64),
        revision=np.zeros((b, k, n), np.int64),
        true_cell=np.zeros((b, n, t), np.int32),
        heading=np.zeros((b, n, t), np.int8),
        bump=np.zeros((b, n, t), np.int8),
        way=np.zeros((b, n, t), np.int32),
        variance=np.zeros((b, n, t), np.float32),
        first_visit=np.zeros((b, n, h, w), np.int32),
        listed=np.zeros((b, n, h, w), np.bool_),
        shown_free=np.zeros((b, n), np.int64),
        noise_key=np.zeros(b, np.uint64),
        drift_key=np.zeros(b, np.uint64),
        pose_error=np.zeros((b, n)),
    )
