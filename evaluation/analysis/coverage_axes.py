"""The axes that coverage is drawn against: steps, distance flown, seconds of decisions, bytes sent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.outliers import near_groups
from indoor_explorers.evaluation.harness.episodes.record import AXES, Record, mean_curve

#: Episodes of a policy that tell where a curve rises.
ENOUGH = 1000
#: How much farther than the last curve's time to the threshold an axis goes, as a factor.
MARGIN = 1.15


class CoverageAxis(NamedTuple):
    """One of ``AXES`` of records with the amounts at which curves are drawn."""

    key: str
    title: str
    unit: str
    log: bool
    """Whether the axis is logarithmic, as amounts differ by orders of magnitude between policies."""
    amounts: NDArray[np.float64]
    """(T,) rising; the last is the largest amount of any episode, for steps the budget."""
    focus: float
    """The amount after which curves hardly change."""


#: Titles of the axes.
TITLES = {"steps": "step", "distance": "distance flown by the team", "seconds": "time of all decisions of the team"} | {
    "bytes": "bytes sent by the team"
}


def axes_of(comparison: Comparison, points: int) -> list[CoverageAxis]:
    """Return the axes with an amount above 0, steps first, with about ``points`` amounts each."""
    records = comparison.records
    others = [key for key in AXES if key != "steps" and max(getattr(record.facts, key) for record in records) > 0]
    steps = sampled_steps(comparison, points).astype(np.float64)
    first = CoverageAxis("steps", TITLES["steps"], AXES["steps"], False, steps, float(focus_step(comparison)))
    return [first, *(_spending(comparison, key, points // 2) for key in others)]


def _spending(comparison: Comparison, key: str, points: int) -> CoverageAxis:
    records = comparison.records
    most = max(getattr(record.facts, key) for record in records)
    if key == "seconds":
        least = min(record.facts.first_seconds for record in records)
        rounded = [float(f"{amount:.4g}") for amount in np.geomspace(least, most, points)[:-1].tolist()]
        return CoverageAxis(key, TITLES[key], AXES[key], True, np.unique([*rounded, most]), most)
    focus = min(most, MARGIN * _focus(comparison, key, np.linspace(0, most, 1000)))
    amounts = np.concatenate((np.linspace(0, focus, points * 2 // 3), np.linspace(focus, most, points // 3)))
    return CoverageAxis(key, TITLES[key], AXES[key], False, np.unique(amounts.round()), round(focus))


def _focus(comparison: Comparison, key: str, amounts: NDArray[np.float64]) -> float:
    """Return which of (T,) amounts the last mean curve reaches the threshold at; the largest if none does."""
    groups = [group[:: 1 + len(group) // ENOUGH] for group in near_groups(comparison).values()]
    means = [coverage_at(group, amounts, axis=key).mean(axis=0) for group in groups]
    enough = comparison.level.share
    return float(max((amounts[np.argmax(m >= enough)] for m in means if m[-1] >= enough), default=amounts[-1]))


def sampled_steps(comparison: Comparison, points: int) -> NDArray[np.int64]:
    """Return (T,) steps, at most about ``points``: dense while any curve still rises, and the last step of all."""
    records = comparison.records
    budget, last = max(record.budget for record in records), max(record.steps for record in records)
    focus = min(focus_step(comparison), last)
    early = np.linspace(0, focus, min(focus + 1, points * 2 // 3)).round()
    late = np.linspace(focus, last, min(last - focus + 1, points // 3)).round()
    return np.unique(np.concatenate((early, late, [budget]))).astype(np.int64)


def focus_step(comparison: Comparison) -> int:
    """Return the step after which curves hardly change, by the policies that are not far behind."""
    near = near_groups(comparison)
    curves = [comparison.results.mean_curve(comparison.scenario, policy) for policy in near]
    return _active_until(curves, max(r.budget for group in near.values() for r in group), comparison.level.share)


def last_active_step(groups: Sequence[Sequence[Record]], share: float) -> int:
    """Return the step, plus a margin, at which the last of the groups' mean curves reaches the share.

    Groups whose mean never reaches it are ignored; the result is the budget when no group reaches it.
    """
    budget = max(record.budget for records in groups for record in records)
    return _active_until([mean_curve(records) for records in groups], budget, share)


def _active_until(curves: Sequence[NDArray[np.float64]], budget: int, share: float) -> int:
    """Return the last step, plus a margin, at which one of the (T,) curves reaches the share; else the budget."""
    reached = [step for curve in curves if (step := _reaches(curve, share)) is not None]
    return min(budget, int(np.ceil(max(reached) * MARGIN)) + 1) if reached else budget


def _reaches(curve: NDArray[np.float64], share: float) -> int | None:
    """Return the first step from which a (T,) mean curve stays at a share or above; None if it ends below."""
    below = np.flatnonzero(curve < share - 1e-12)
    first = int(below[-1]) + 1 if len(below) else 0
    return first if first < len(curve) else None


def coverage_at(
    records: Sequence[Record], amounts: NDArray[np.integer | np.floating], who: str = "team", axis: str = "steps"
) -> NDArray[np.float64]:
    """Return (E, T) coverage when T ``amounts`` of an axis were spent, each curve constant after its end.

    ``who`` is as in :meth:`~indoor_explorers.evaluation.harness.episodes.record.Record.coverage`.
    """
    return coverage_along(records, {axis: amounts}, [who])[axis, who]


def coverage_along(
    records: Sequence[Record], axes: Mapping[str, NDArray[np.integer | np.floating]], who: Sequence[str]
) -> dict[tuple[str, str], NDArray[np.float64]]:
    """Return :func:`coverage_at`, (E, T), by axis and ``who`` for (T,) amounts of each axis; episodes are read once.

    All are views of one array.
    """
    total = sum(len(amounts) for amounts in axes.values())
    whole = np.empty((len(records), len(who) * total))
    for place, record in enumerate(records):
        steps = np.concatenate([_step(record, amounts, axis) for axis, amounts in axes.items()])
        whole[place] = record.coverage_of(who, steps).ravel()
    ends = np.cumsum([len(amounts) for _ in who for amounts in axes.values()])
    keys = [(axis, each) for each in who for axis in axes]
    return dict(zip(keys, np.split(whole, ends[:-1], axis=1), strict=True))


def _step(record: Record, amounts: NDArray[np.integer | np.floating], axis: str) -> NDArray[np.integer]:
    """Return (T,) the last step up to which no more than each of (T,) amounts was spent."""
    if axis == "steps":
        return np.asarray(np.minimum(amounts, record.steps), np.int64)
    return np.asarray(np.maximum(np.searchsorted(record.spent(axis), amounts, side="right") - 1, 0))
