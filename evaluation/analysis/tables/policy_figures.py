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


def figures(
    comparison: Comparison,
    policy: str,
    times: Sequence[str],
    best: Mapping[str, Sequence[str]],
    decimals: Callable[[float], int],
) -> list[Cell]:
    """Return the cells below :func:`headings`; ``decimals`` are those of a mean time."""

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


def ratios(comparison: Comparison, policy: str, *, to_bound: bool, to_reference: bool) -> list[Cell]:
    """Return the mean ratios of a policy's steps to the lower bound and to the policy that knows the map."""
    found = [_ratio_to_bound(comparison, policy)] if to_bound else []
    found += [_ratio_to_reference(comparison, policy)] if to_reference else []
    return [_ratio(*each) if each else Cell() for each in found]


def _ratio(sign: str, estimate: Estimate) -> Cell:
    return Cell(bounded(fixed(estimate.mean, 2), sign), detail="" if sign else interval(estimate, 2))


def _ratio_to_reference(comparison: Comparison, policy: str) -> tuple[str, Estimate] | None:
    """Return the mean ratio of a policy's steps to those of the reference, and its sign.

    The sign is that of a bound, or empty. There is no ratio for a policy that knows the map, and where none is known.
    """
    estimate, bound = comparison.to_reference(policy), comparison.reference_censoring(policy).bound
    if comparison.privileged(policy) or math.isnan(estimate.mean) or bound is None:
        return None
    return bound, estimate


def _ratio_to_bound(comparison: Comparison, policy: str) -> tuple[str, Estimate] | None:
    """Return the mean ratio of T99 to its lower bound, and its sign: ``>`` where some episodes never got there."""
    estimate = comparison.estimate(policy, "t99_to_bound")
    if math.isnan(estimate.mean):
        return None
    return ("" if comparison.success(policy).mean == 1 else ">"), estimate


def _latency(microseconds: float) -> str:
    """Format a time with a suitable unit."""
    if math.isnan(microseconds):
        return fixed(None, 0)
    for unit, size in (("s", 1e6), ("ms", 1e3)):
        if microseconds >= size:
            return f"{fixed(microseconds / size, 1)} {unit}"
    return f"{fixed(microseconds, 0)} µs"
