"""Lower bounds: steps that no team can do without, however well it flies and whatever it knows."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import World


def least_steps(world: World, episode: int, share: float) -> int:
    """Return a certified lower bound on the steps to a team coverage of ``share``, for an episode that has just begun.

    What a UAV has seen lies within lidar range of where it has been. The discs around the starts hold a known number
    of counted cells, and a move shifts a disc by one cell, which adds at most one cell in each of its 2 floor(R) + 1
    rows or columns. So N UAVs cover at most that many plus N (2 floor(R) + 1) t counted cells in t steps. Walls are
    left out, which makes the bound weak in mazes and never wrong.
    """
    state, lidar = world.state, world.scenario.lidar
    reach = lidar.range + (0.5 if lidar.model == "marsexplorer" else 0.0)  # that one overshoots by half a cell
    starts = state.cell[episode]
    missing = math.ceil(share * int(state.total[episode]) - 1e-9) - _within(state.counts[episode], starts, reach)
    gain = len(starts) * (2 * math.floor(reach + 1e-9) + 1)
    return max(0, math.ceil(missing / gain))


def _within(counts: NDArray[np.bool_], starts: NDArray[np.int64], reach: float) -> int:
    """Return how many counted cells lie within ``reach`` of any of the (N, 2) starts."""
    rows, columns = np.indices(counts.shape)
    near = np.zeros(counts.shape, np.bool_)
    for row, column in starts.tolist():
        near |= (rows - row) ** 2 + (columns - column) ** 2 <= reach**2 + 1e-9
    return int((near & counts).sum())
