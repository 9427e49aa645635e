"""Times to a coverage threshold that some episodes never reach within their budget.

Such a time is censored: it is only known to be longer than the budget. No episode is dropped. Since all
episodes of a scenario are censored at the same budget, the share of episodes that have reached it by a step is
a plain count, equal to the Kaplan-Meier estimate (Kaplan & Meier 1958, doi:10.1080/01621459.1958.10501452).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import InputError

#: First steps at a threshold, (E,): NaN or None where it was never reached.
Times = NDArray[np.floating] | Sequence[float | None]


def ecdf_of_times(times: Times, budget: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (steps, share), both (N,): the share of episodes that have reached a threshold by each step.

    The share is constant between steps. ``steps`` are 0, the steps at which an episode reached it, and the budget.
    The last share is the success rate, and none is above it.

    Args:
        times: (E,) first steps, NaN or None for never.
        budget: steps after which an episode was ended.

    Raises:
        InputError: there is no episode, or a time is not between 0 and the budget.

    """
    reached = _checked(times, budget)
    reached = np.sort(reached[~np.isnan(reached)])
    steps = np.unique(np.concatenate(([0.0], reached, [float(budget)])))
    return steps, np.searchsorted(reached, steps, side="right") / len(times)


def _checked(times: Times, budget: float) -> NDArray[np.float64]:
    found = np.asarray(times, np.float64)
    if found.ndim != 1 or not len(found):
        raise InputError(f"expected the times of at least one episode, got shape {found.shape}; pass one time each")
    wrong = found[~np.isnan(found) & ~((found >= 0) & (found <= budget))]
    if len(wrong):
        raise InputError(
            f"expected times from 0 to the budget of {budget:g} steps, got {wrong[0]:g}; pass NaN where never reached"
        )
    return found
