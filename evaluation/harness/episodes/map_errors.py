"""Metrics of maps and poses that can be wrong."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import UNKNOWN, World


def map_metrics(world: World, episode: int, flown: NDArray[np.integer]) -> dict[str, float | None]:
    """Return ``map_error``, ``claimed`` and ``pose_error`` of an episode that has ended.

    ``flown`` (N,) is the number of steps that each UAV flew.
    """
    assert world.slam is not None
    state = world.state
    shown, truth, counts = state.union[episode], state.truth[episode], state.counts[episode]
    known, steps = shown != UNKNOWN, int(flown.sum())
    return {
        "map_error": float((shown != truth)[known].mean()) if known.any() else None,
        "claimed": float((known & counts).sum() / state.total[episode]),
        "pose_error": float(world.slam.pose_error[episode].sum() / steps) if steps else None,
    }
