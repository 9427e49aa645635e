"""The figures of a policy on a scenario that the terminal and the exports show."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.failures import failed
from indoor_explorers.evaluation.analysis.shown_best import shown_best
from indoor_explorers.evaluation.analysis.tables.policy_names import BATCH_SHARE
from indoor_explorers.evaluation.analysis.tables.ratio_table import bounded
from indoor_explorers.evaluation.drawing.formatting import fixed, interval, percent, percent_interval
from indoor_explorers.evaluation.drawing.table import Cell
from indoor_explorers.evaluation.harness.results.coverage_threshold import CoverageThreshold, shared, tabled
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import Estimate


def headings(levels: Sequence[CoverageThreshold]) -> list[str]:
    """Return the columns of scenarios with these thresholds: times, success, failures, AUC and decision time."""
    times = [f"{CoverageThreshold(key).title} [steps]" for key in tabled(levels)]
    level = shared(levels)
    return [*times, f"{level.percent} reached" if level else "reached", "failed", "AUC", "decision p50"]


def short_headings(levels: Sequence[CoverageThreshold]) -> list[str]:
    """Return the short headings of a narrow table: times and success."""
    level = shared(levels)
    return [*(CoverageThreshold(key).title for key in tabled(levels)), level.percent if level else "reached"]


def reference_of(results: Results) -> str | None:
    """Return the first policy that knows the map and flew a task: the baseline of ratios of steps."""
    return next(
        (name for name in results.privileged_policies if any(policy == name for _, policy in results.groups)), None
    )


def best_of(comparison: Comparison) -> dict[str, list[str]]:
    """Return the policies that are shown to be the best in each time and in AUC."""
    metrics = (*comparison.level.times, "auc")
    return {metric: shown_best(comparison, metric, lower_is_better=metric != "auc") for metric in metrics}


def result_cells(
    comparison: Comparison,
    policy: str,
    times: Sequence[str],
    best: Mapping[str, Sequence[str]],
    decimals: Callable[[float], int],
) -> list[Cell]:
    """Return the cells below :func:`headings`; ``decimals`` gives the decimals of a mean time."""

    def measured(metric: str, decimals: Callable[[float], int]) -> Cell:
        estimate = comparison.estimate(policy, metric)
        digits, is_best = decimals(estimate.mean), policy in best.get(metric, ())
        return Cell(fixed(estimate.mean, digits), detail=interval(estimate, digits), best=is_best)

    success, failures = comparison.success(policy), len(failed(comparison.groups[policy]))
    return [
        *(measured(key, decimals) for key in times),
        Cell(percent(success.mean), detail=percent_interval(success)),
        Cell(str(failures), bad=failures > 0),
        measured("auc", lambda mean: 3),
        Cell(_decision_time(comparison, policy)),
    ]


def _decision_time(comparison: Comparison, policy: str) -> str:
    """Return the median decision time of a policy, marked if it is a share of a batch's."""
    shown = _latency(comparison.estimate(policy, "latency_p50_us").mean)
    return f"{shown} ({BATCH_SHARE})" if policy in comparison.results.batched_policies else shown


def ratio_cells(comparison: Comparison, policy: str, *, to_bound: bool, to_reference: bool) -> list[Cell]:
    """Return the mean ratios of a policy's steps to the lower bound and to the policy that knows the map."""
    found = [_to_bound(comparison, policy)] if to_bound else []
    return found + ([_to_reference(comparison, policy)] if to_reference else [])


def _to_bound(comparison: Comparison, policy: str) -> Cell:
    """Return the ratio of T99 to its lower bound, with the sign of a bound where some episodes never got there."""
    return _ratio(comparison.estimate(policy, "t99_to_bound"), "" if comparison.reached(policy) == 1 else ">")


def _to_reference(comparison: Comparison, policy: str) -> Cell:
    """Return the ratio of steps to the reference's steps; empty for a policy that knows the map."""
    bound = comparison.reference_censoring(policy).bound
    if comparison.privileged(policy) or bound is None:
        return Cell()
    return _ratio(comparison.to_reference(policy), bound)


def _ratio(ratio: Estimate, sign: str) -> Cell:
    if math.isnan(ratio.mean):
        return Cell()
    return Cell(bounded(fixed(ratio.mean, 2), sign), detail="" if sign else interval(ratio, 2))


def _latency(microseconds: float) -> str:
    """Format a time with a suitable unit."""
    if math.isnan(microseconds):
        return fixed(None, 0)
    for unit, size in (("s", 1e6), ("ms", 1e3)):
        if microseconds >= size:
            return f"{fixed(microseconds / size, 1)} {unit}"
    return f"{fixed(microseconds, 0)} µs"
