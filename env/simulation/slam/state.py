"""Additional state of worlds with sensor noise or drift.

Axes as in :mod:`indoor_explorers.env.simulation.state`; K = N + 1 map holders, the agents and the team, and one more
with a home base; T scans of one agent, one for each step and one for the start.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import allocated
from indoor_explorers.env.scenarios.scenario import LEAST_BUDGET, Scenario
from indoor_explorers.env.sensing.field_of_view import least_cosine
from indoor_explorers.env.sensing.lidar import LidarModel
from indoor_explorers.env.simulation.engine import Work
from indoor_explorers.env.simulation.state import Rules, State


class ErrorRules(NamedTuple):
    """A scenario's errors as numbers for compiled code."""

    misses: float
    false_returns: float
    range_std: float
    least_cosine: float
    """Least cosine of the angle between the heading and a cell in the field of view; below -1 for all around."""
    drift: float
    closures: float
    closure_gap: int
    mates: bool


class Slam(NamedTuple):
    """Scans, estimated poses and maps of a batch of episodes."""

    log_odds: Annotated[NDArray[np.float32], "B K H W"]
    """Log-odds that a cell is occupied: the sum of all readings that the holder has of it; 0 for none."""
    drawn_at: Annotated[NDArray[np.int32], "B K N T"]
    """Flat cell from which a holder's map has the scan of an agent; -1 for a scan that it has not."""
    scans: Annotated[NDArray[np.int64], "B K N"]
    """Scans of each agent that a holder has."""
    revision: Annotated[NDArray[np.int64], "B K N"]
    """Corrections of each agent's path that a holder has."""
    true_cell: Annotated[NDArray[np.int32], "B N T"]
    """Flat cell in which a scan was made."""
    heading: Annotated[NDArray[np.int8], "B N T"]
    """Action whose direction the agent faced in a scan."""
    bump: Annotated[NDArray[np.int8], "B N T"]
    """Action that ended in an obstacle right before a scan; -1 for none."""
    way: Annotated[NDArray[np.int32], "B N T"]
    """Cells flown before a scan."""
    variance: Annotated[NDArray[np.float32], "B N T"]
    """Expected squared error of the pose of a scan, in cells^2."""
    first_visit: Annotated[NDArray[np.int32], "B N H W"]
    """First scan that an agent made in a cell; -1 for none."""
    listed: Annotated[NDArray[np.bool_], "B N H W"]
    """Cells in the discovery log."""
    shown_free: Annotated[NDArray[np.int64], "B N"]
    """Flat cell that an agent's map shows as free since it believes to be there."""
    noise_key: Annotated[NDArray[np.uint64], "B"]
    """Key of the stream of the lidar's errors."""
    drift_key: Annotated[NDArray[np.uint64], "B"]
    """Key of the stream of the drift."""
    pose_error: Annotated[NDArray[np.float64], "B N"]
    """Sum over the steps flown of the distance between the believed and the true cell."""


class Readings(NamedTuple):
    """Working arrays of a scan with errors, not to be shared between threads."""

    cells: NDArray[np.int64]
    """Flat cells that were read, as seen from the true cell."""
    values: NDArray[np.float32]
    """Log-odds of each."""
    place: NDArray[np.int32]
    """(H * W,) index + 1 of a cell in ``cells``; 0 between scans."""
    occupancy: NDArray[np.uint8]
    """(H, W) the distorted map of one scan."""


class SlamParts(NamedTuple):
    """The arguments of the compiled functions of a step with errors."""

    rules: Rules
    errors: ErrorRules
    state: State
    slam: Slam
    lidar: LidarModel
    work: Work
    readings: Readings


def error_rules_of(scenario: Scenario) -> ErrorRules:
    """Translate a scenario."""
    return ErrorRules(
        misses=scenario.noise.misses,
        false_returns=scenario.noise.false_returns,
        range_std=scenario.noise.range_std,
        least_cosine=least_cosine(scenario.lidar.field_of_view),
        drift=scenario.drift.rate,
        closures=scenario.drift.closures,
        closure_gap=scenario.drift.closure_gap,
        mates=scenario.drift.mates,
    )


def empty_slam(scenario: Scenario, batch: int, shape: tuple[int, int]) -> Slam:
    """Allocate what ``batch`` episodes on (H, W) maps hold."""
    (height, width), team = shape, scenario.team
    scans = 1 + (scenario.budget or max(LEAST_BUDGET, height * width))
    return allocated(Slam, B=batch, K=team + 1 + scenario.base.exists, N=team, T=scans, H=height, W=width)
