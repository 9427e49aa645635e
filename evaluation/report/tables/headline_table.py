"""The results in short, for a terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich import box
from rich.table import Table
from rich.text import Text

from indoor_explorers.evaluation.report.analysis.comparison import Comparison
from indoor_explorers.evaluation.report.analysis.failures import failed
from indoor_explorers.evaluation.report.style.formatting import decimals_for, fixed, percent, with_interval
from indoor_explorers.evaluation.report.tables.policy_names import BATCH_SHARE, footnotes, marked
from indoor_explorers.evaluation.results.coverage_threshold import CoverageThreshold, shared, tabled
from indoor_explorers.evaluation.results.results import Results
from indoor_explorers.evaluation.statistics import Estimate

#: Characters of a line from which on all columns fit beside a name.
WIDE = 110
#: The same with the ratio to a policy that knows the map.
WIDEST = 135
#: Characters of one more time.
A_TIME = 22


def headings(levels: Sequence[CoverageThreshold]) -> list[str]:
    """Return what the columns of scenarios judged by these levels hold: times, success, failures, AUC and latency."""
    times = [f"{CoverageThreshold(key).title} [steps]" for key in tabled(levels)]
    level = shared(levels)
    return [*times, f"{level.percent} reached" if level else "reached", "failed", "AUC", "decision p50"]


def narrow(levels: Sequence[CoverageThreshold]) -> list[str]:
    """Return the first of :func:`headings`, shorter: times and success."""
    level = shared(levels)
    return [*(CoverageThreshold(key).title for key in tabled(levels)), level.percent if level else "reached"]


def headline_table(results: Results, width: int = WIDE) -> Table:
    """Return one row per scenario and policy: T90 and T99 with interval, success; failures, AUC and latency.

    The last three are left out where lines have less than :data:`WIDE` characters. Where a policy that knows the map
    flew the same tasks, the mean ratio of steps to it comes last. Success and ratio are of the level that a scenario
    is judged by, which has a column too; times that a scenario does not ask for are a dash.
    """
    known, levels = knowing(results), results.levels
    level, times = shared(levels), tabled(levels)
    wide = (WIDEST if known else WIDE) + A_TIME * (len(times) - 2)
    shown = headings(levels) if width >= wide else narrow(levels)
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("policy", overflow="fold", min_width=min(24, max(map(len, results.policies), default=0)))
    for heading in shown:
        table.add_column(heading, justify="right", no_wrap=True)
    if known:
        table.add_column(f"{level.title if level else 'steps'} / {known}", justify="right", no_wrap=True)
    table.caption = "\n".join(footnotes(results, [policy for _, policy in results.groups], times=width >= wide)) or None
    for scenario in results.scenarios:
        if len(results.scenarios) > 1:
            name = scenario if level else f"{scenario} ({results.level(scenario).title})"
            table.add_row(Text(name, "bold"))
        comparison = Comparison(results, scenario)
        for policy in comparison.groups:
            ratio = [Text(_ratio(comparison, policy))] if known else []
            table.add_row(*_row(comparison, policy, times)[: 1 + len(shown)], *ratio)
        table.add_section()
    return table


def knowing(results: Results) -> str | None:
    """Return the policy that ratios of steps are taken to: the first one that knows the map and flew any task."""
    return next(
        (name for name in results.privileged_policies if any(policy == name for _, policy in results.groups)), None
    )


def _row(comparison: Comparison, policy: str, times: Sequence[str]) -> list[Text]:
    level = comparison.level.key
    best = policy == comparison.ranked_policies[0] and len(comparison.ranked_policies) > 1
    failures = len(failed(comparison.groups[policy]))
    return [
        Text(marked(comparison.results, policy), "dim" if comparison.privileged(policy) else ""),
        *(Text(_steps(comparison.estimate(policy, key)), "bold" if best and key == level else "") for key in times),
        Text(percent(comparison.reached(policy))),
        Text(str(failures), "bold red" if failures else ""),
        Text(fixed(comparison.estimate(policy, "auc").mean, 3)),
        Text(decision_time(comparison, policy)),
    ]


def decision_time(comparison: Comparison, policy: str) -> str:
    """Return the median time of a policy's decisions; says so where it is a share of a batch's."""
    shown = latency(comparison.estimate(policy, "latency_p50_us").mean)
    return f"{shown} ({BATCH_SHARE})" if policy in comparison.results.batched_policies else shown


def _ratio(comparison: Comparison, policy: str) -> str:
    if comparison.privileged(policy):
        return ""
    estimate = comparison.to_reference(policy)
    return "" if math.isnan(estimate.mean) else with_interval(estimate, 2)


def _steps(estimate: Estimate) -> str:
    return with_interval(estimate, decimals_for(estimate.mean))


def latency(microseconds: float) -> str:
    """Format a time in the unit that suits it."""
    if math.isnan(microseconds):
        return fixed(None, 0)
    for unit, size in (("s", 1e6), ("ms", 1e3)):
        if microseconds >= size:
            return f"{fixed(microseconds / size, 1)} {unit}"
    return f"{fixed(microseconds, 0)} µs"
