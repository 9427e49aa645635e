"""The results in short, for a terminal."""

from __future__ import annotations

import math

from rich import box
from rich.table import Table
from rich.text import Text

from indoor_explorers.evaluation.report.comparison import Comparison
from indoor_explorers.evaluation.report.numbers import decimals_for, fixed, percent, with_interval
from indoor_explorers.evaluation.report.tables import failed
from indoor_explorers.evaluation.results import Results
from indoor_explorers.evaluation.statistics import Estimate

HEADINGS = ("T90 [steps]", "T99 [steps]", "99 % reached", "failed", "AUC", "decision p50")
#: The first of them, shorter.
NARROW = ("T90", "T99", "99 %")
#: Characters of a line from which on all columns fit beside a name.
WIDE = 110
#: The same with the ratio to a policy that knows the map.
WIDEST = 135


def headline_table(results: Results, width: int = WIDE) -> Table:
    """Return one row per scenario and policy: T90 and T99 with interval, success; failures, AUC and latency.

    The last three are left out where lines have less than :data:`WIDE` characters. Where a policy that knows the map
    flew the same tasks, the mean ratio of T99 to it comes last.
    """
    known = knowing(results)
    shown = HEADINGS if width >= (WIDEST if known else WIDE) else NARROW
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("policy", overflow="fold", min_width=min(24, max(map(len, results.policies), default=0)))
    for heading in shown:
        table.add_column(heading, justify="right", no_wrap=True)
    if known:
        table.add_column(f"T99 / {known}", justify="right", no_wrap=True)
    for scenario in results.scenarios:
        if len(results.scenarios) > 1:
            table.add_row(Text(scenario, "bold"))
        comparison = Comparison(results, scenario)
        for policy in comparison.groups:
            ratio = [Text(_ratio(comparison, policy))] if known else []
            table.add_row(*_row(comparison, policy)[: 1 + len(shown)], *ratio)
        table.add_section()
    return table


def knowing(results: Results) -> str | None:
    """Return the policy that ratios of T99 are taken to: the first one that knows the map and flew any task."""
    return next((name for name in results.knowing if any(policy == name for _, policy in results.groups)), None)


def _row(comparison: Comparison, policy: str) -> list[Text]:
    best = policy == comparison.contestants[0] and len(comparison.contestants) > 1
    failures = len(failed(comparison.groups[policy]))
    name = f"{policy} (knows the map)" if comparison.privileged(policy) else policy
    return [
        Text(name, "dim" if comparison.privileged(policy) else ""),
        Text(_steps(comparison.estimate(policy, "t90"))),
        Text(_steps(comparison.estimate(policy, "t99")), "bold" if best else ""),
        Text(percent(comparison.results.success(comparison.scenario, policy, "t99"))),
        Text(str(failures), "bold red" if failures else ""),
        Text(fixed(comparison.estimate(policy, "auc").mean, 3)),
        Text(latency(comparison.estimate(policy, "latency_p50_us").mean)),
    ]


def _ratio(comparison: Comparison, policy: str) -> str:
    if comparison.privileged(policy):
        return ""
    estimate = comparison.results.estimates(comparison.scenario, policy).get("t99_to_reference")
    return with_interval(estimate, 2) if estimate else ""


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
