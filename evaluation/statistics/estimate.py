"""Estimates with intervals, and checks of the values that they are made from."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.env import InputError

#: Fewer episodes than this get no interval; fewer maps than this are taken as fixed.
FEWEST = 5
#: Bootstrap resamples of an interval.
RESAMPLES = 10_000
#: Nominal coverage of intervals and bands; a difference is significant where p <= 1 - CONFIDENCE.
CONFIDENCE = 0.95
#: The (E,) labels of the maps that E episodes were flown on; None where each episode counts as a map of its own.
Maps = ArrayLike | None


class Estimate(NamedTuple):
    """A mean with its interval; ``low`` and ``high`` are None where there are too few episodes."""

    mean: float
    low: float | None
    high: float | None


def episode_values(values: ArrayLike) -> NDArray[np.float64]:
    """Return (E,) values of episodes as floats.

    Raises:
        InputError: there is not one finite number for each episode.

    """
    sample = np.asarray(values, np.float64)
    if sample.ndim != 1:
        raise InputError(f"expected values of shape (episodes,), got {sample.shape}; pass one number an episode")
    if not np.isfinite(sample).all():
        missing = int((~np.isfinite(sample)).sum())
        raise InputError(
            f"expected finite values, got {missing} of {len(sample)} that are not; "
            "count what was never reached as its budget, or leave out the task for every policy"
        )
    return sample


def paired_values(values: ArrayLike, baseline: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the (E,) values of two policies on the same tasks.

    Raises:
        InputError: the numbers of values differ, or there is not one finite number for each episode.

    """
    one, other = episode_values(values), episode_values(baseline)
    if len(one) != len(other):
        raise InputError(f"expected pairs on the same tasks, got {len(one)} and {len(other)} values; keep common tasks")
    return one, other
