"""The knowledge that observations are computed from: of all UAVs, and of one UAV together with its memory."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.compiled import inner
from indoor_explorers.learners.dddqn.observation.memory import ObservationMemory


class Known(NamedTuple):
    """Knowledge of C UAVs in teams of M."""

    belief: np.ndarray
    """(C, H, W) uint8; read-only as in a pilot's view, so that kernels compile for one array type only."""
    cell: np.ndarray
    """(C, 2) int64: row and column of the UAV."""
    mates: np.ndarray
    """(C, M, 2) int64: last received cell of each UAV of the team."""
    ages: np.ndarray
    """(C, M) int64: age of that cell in steps, -1 for never received and for the UAV itself."""
    agent: np.ndarray
    """(C,) int64: the UAV's number in its team."""
    flown: np.ndarray
    """(C,) float64: used share of the step budget."""


class Uav(NamedTuple):
    """The knowledge and the memory of one UAV; arrays of the memory are views, which an observation updates."""

    row: int
    """Row of its cell."""
    col: int
    """Column of its cell."""
    agent: int
    """Its number in its team."""
    flown: float
    """Used share of the step budget."""
    belief: np.ndarray
    """(H, W); these and all following ones are described in :class:`.Known` and :class:`.ObservationMemory`."""
    mates: np.ndarray
    """(M, 2)."""
    ages: np.ndarray
    """(M,)."""
    noted: np.ndarray
    """(H, W)."""
    visits: np.ndarray
    """(H, W)."""
    barred: np.ndarray
    """(H, W)."""
    chance: np.ndarray
    """(H, W)."""
    gain: np.ndarray
    """(H, W)."""
    weight: np.ndarray
    """(H, W), or (0, 0)."""
    obstacles: np.ndarray
    """(H, W)."""
    prospect: np.ndarray
    """(2,)."""
    views: np.ndarray
    """(R, 4)."""
    passages: np.ndarray
    """(R, 4)."""
    tour: np.ndarray
    """(2, 41)."""
    theirs: np.ndarray
    """(M, 4), or (0, 4)."""
    aimed: np.ndarray
    """(1,); so all that follow."""
    looks: np.ndarray
    pushes: np.ndarray
    gained: np.ndarray
    idle: np.ndarray
    nearest: np.ndarray


@inner()
def uav_of(known: Known, memory: ObservationMemory, i: int) -> Uav:
    """Return the knowledge and the memory of UAV ``i``; for leaves alone.

    Its views of arrays are not counted as references, and a function that counts them would free the arrays.
    """
    return Uav(
        known.cell[i, 0],
        known.cell[i, 1],
        known.agent[i],
        known.flown[i],
        known.belief[i],
        known.mates[i],
        known.ages[i],
        memory.noted[i],
        memory.visits[i],
        memory.barred[i],
        memory.chance[i],
        memory.gain[i],
        memory.weight[i],
        memory.obstacles[i],
        memory.prospect[i],
        memory.views[i],
        memory.passages[i],
        memory.tour[i],
        memory.theirs[i],
        memory.aimed[i : i + 1],
        memory.looks[i : i + 1],
        memory.pushes[i : i + 1],
        memory.gained[i : i + 1],
        memory.idle[i : i + 1],
        memory.nearest[i : i + 1],
    )
