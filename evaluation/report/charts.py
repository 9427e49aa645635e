"""The data of the coverage charts: mean curves and bands on few steps, small enough to embed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.record import Record
from indoor_explorers.evaluation.report.comparison import Comparison
from indoor_explorers.evaluation.report.packing import shares
from indoor_explorers.evaluation.report.palette import Style
from indoor_explorers.evaluation.statistics import FEWEST, curve_band

#: Whose coverage a chart can show.
WHO = ("team", "worst", "mean")


def sampled_steps(comparison: Comparison, points: int) -> NDArray[np.int64]:
    """Return at most about ``points`` steps: dense while any curve still rises, and the last step of all."""
    records = [record for records in comparison.groups.values() for record in records]
    budget, last = max(record.budget for record in records), max(record.steps for record in records)
    focus = min(focus_step(comparison), last)
    early = np.linspace(0, focus, min(focus + 1, points * 2 // 3)).round()
    late = np.linspace(focus, last, min(last - focus + 1, points // 3)).round()
    return np.unique(np.concatenate((early, late, [budget]))).astype(np.int64)


def focus_step(comparison: Comparison) -> int:
    """Return the step after which little happens: the last mean curve to get to 99 % is there.

    Policies whose mean never gets there do not count, unless none does: then it is the budget.
    """
    budget = max(record.budget for records in comparison.groups.values() for record in records)
    reached = [step for records in comparison.groups.values() if (step := _mean_reaches(records, 0.99)) is not None]
    return min(budget, int(np.ceil(max(reached) * 1.15)) + 1) if reached else budget


def _mean_reaches(records: Sequence[Record], level: float) -> int | None:
    """Return the first step at which the mean team coverage is at ``level``; coverage never falls, so halve."""

    def there(step: int) -> bool:
        return float(coverage_at(records, np.array([step])).mean()) >= level - 1e-12

    low, high = 0, max(record.steps for record in records)
    if not there(high):
        return None
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if there(middle) else (middle + 1, high)
    return low


def coverage_at(records: Sequence[Record], steps: NDArray[np.int64], who: str = "team") -> NDArray[np.float64]:
    """Return (E, T) coverage at T ``steps``, each curve constant after its end, without unrolling the budget."""
    return np.stack(
        [_covered(record.covered[np.minimum(steps, record.steps)], who) / record.reachable for record in records]
    )


def _covered(rows: NDArray[np.int32], who: str) -> NDArray[np.float64]:
    own = rows[:, 1:]
    return np.asarray({"team": rows[:, 0], "mean": own.mean(axis=1), "worst": own.min(axis=1)}[who], np.float64)


def chart_data(comparison: Comparison, looks: Mapping[str, Style], points: int = 360) -> dict[str, Any]:
    """Return the coverage chart of a scenario as JSON data."""
    steps = sampled_steps(comparison, points)
    team = max(record.team for records in comparison.groups.values() for record in records)
    return {
        "steps": steps.tolist(),
        "focus": focus_step(comparison),
        "budget": int(steps[-1]),
        "who": list(WHO if team > 1 else WHO[:1]),
        "policies": [
            {
                "name": policy,
                **looks[policy]._asdict(),
                "pattern": looks[policy].pattern,
                "privileged": comparison.privileged(policy),
                "curves": {who: _curves(comparison, policy, steps, who) for who in (WHO if team > 1 else WHO[:1])},
            }
            for policy in comparison.groups
        ],
    }


def _curves(comparison: Comparison, policy: str, steps: NDArray[np.int64], who: str) -> dict[str, Any]:
    curves = coverage_at(comparison.groups[policy], steps, who)
    if len(curves) < FEWEST:
        return {"mean": shares(curves.mean(axis=0)), "each": [shares(curve) for curve in curves]}
    mean, low, high = curve_band(curves)
    return {"mean": shares(mean), "low": shares(low), "high": shares(high)}
