"""The record of one flown episode."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.evaluation.experiment import Task


class Outcome(StrEnum):
    """How an episode ended."""

    COMPLETE = "complete"
    """The scenario's goal coverage was reached."""
    BUDGET = "budget"
    """The step budget ran out first."""
    ENDED = "ended"
    """Every UAV crashed or was ended as stuck first."""
    FAILED = "failed"
    """The policy broke: it raised, or returned something that is no action."""


@dataclass(frozen=True, eq=False)
class Record:
    """What is kept of one episode of S steps by N UAVs."""

    policy: str
    task: Task
    floorplan: Floorplan = field(repr=False)
    team: int
    budget: int
    """Steps."""
    reachable: int
    """The coverage denominator in cells."""
    outcome: Outcome
    reason: str
    """Why a failed episode failed, or what ended the UAVs; empty when all is well."""
    steps: int
    """Steps flown."""
    metrics: dict[str, float | None]
    """By the names of :data:`indoor_explorers.evaluation.metrics.MEASURES`, and what the pilots tallied."""
    covered: NDArray[np.int32] = field(repr=False)
    """(S + 1, 1 + N) covered cells after each step: the team's union, then each UAV's own map."""
    cells: NDArray[np.int16] = field(repr=False)
    """(S + 1, N, 2) row and column of each UAV after each step."""

    @property
    def curve(self) -> NDArray[np.float64]:
        """(S + 1,) team coverage after each step."""
        return np.asarray(self.covered[:, 0] / self.reachable)
