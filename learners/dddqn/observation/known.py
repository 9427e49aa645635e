"""The current knowledge that observations are computed from, one row per UAV."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


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
