"""What UAVs know when they observe, beside what they remember: one row for each."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Known(NamedTuple):
    """What C UAVs know, of up to M teammates each."""

    belief: np.ndarray
    """(C, H, W) uint8, read-only as in a pilot's view, lest everything is compiled twice."""
    cell: np.ndarray
    """(C, 2) int64."""
    mates: np.ndarray
    """(C, M, 2) int64: where each UAV of the team was last heard."""
    ages: np.ndarray
    """(C, M) int64: how many steps ago, -1 for never and for itself."""
    agent: np.ndarray
    """(C,) int64: each UAV's number in its team."""
    flown: np.ndarray
    """(C,) float64: the share of its steps that are flown."""
