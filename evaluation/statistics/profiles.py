"""Performance profiles: how often a policy is within a factor of the best one (Dolan & More 2002)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import InputError


def performance_ratios(times: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return (E, P) ratios of each policy's steps to those of the best policy on the same task.

    A NaN stands for a threshold that was never reached and gives an infinite ratio. One that was reached at the
    start counts as one step.

    Args:
        times: (E, P) steps of P policies on E tasks.

    Raises:
        InputError: ``times`` is not (E, P), or a time is negative.

    """
    steps = _table(times, 0, "steps of at least 0", "pass NaN where never reached")
    steps = np.where(np.isnan(steps), np.inf, np.maximum(steps, 1.0))
    best = steps.min(axis=1, keepdims=True)
    solved = np.isfinite(steps)
    ratios = np.full_like(steps, np.inf)
    np.divide(steps, best, out=ratios, where=solved)
    return ratios


def performance_profile(ratios: NDArray[np.floating]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (tau, share): the share of tasks on which a policy needs at most tau times the best one's steps.

    ``tau`` (T,) holds 1 and every finite ratio, rising; ``share`` (T, P) is constant between them. At tau = 1
    it says how often a policy is the best or as good, at the last tau how often it solves a task at all. Profiles
    order two policies reliably, and more only with care: the best policy on a task depends on which policies took part
    (Dolan & More 2002, doi:10.1007/s101070100263; Gould & Scott 2016, doi:10.1145/2950048).

    Args:
        ratios: (E, P), from :func:`performance_ratios`; infinite where never reached.

    Raises:
        InputError: ``ratios`` is not (E, P), or a ratio is below 1.

    """
    table = _table(ratios, 1, "ratios of at least 1", "divide by the steps of the best policy on the task")
    tau = np.unique(np.concatenate(([1.0], table[np.isfinite(table)])))
    reached = [np.searchsorted(np.sort(column), tau, side="right") for column in table.T]
    return tau, np.stack(reached, axis=1) / len(table)


def _table(values: NDArray[np.floating], least: float, what: str, fix: str) -> NDArray[np.float64]:
    table = np.asarray(values, np.float64)
    if table.ndim != 2 or not table.size:
        raise InputError(f"expected an array of (tasks, policies), got shape {table.shape}; pass one row for each task")
    if (table < least).any():
        raise InputError(f"expected {what}, got {np.nanmin(table):g}; {fix}")
    return table
