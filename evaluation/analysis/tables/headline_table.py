"""The terminal's table of results."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from rich import box
from rich.table import Table
from rich.text import Text

from indoor_explorers.evaluation.analysis.comparability import missing_episodes
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.failures import failed, failed_of
from indoor_explorers.evaluation.analysis.notes import scenario_notes
from indoor_explorers.evaluation.analysis.shown_best import BOLD, shown_best
from indoor_explorers.evaluation.analysis.tables.policy_names import BATCH_SHARE, footnotes, marked
from indoor_explorers.evaluation.drawing.formatting import decimals_for, fixed, percent, with_interval
from indoor_explorers.evaluation.harness.results.coverage_threshold import T99, CoverageThreshold, shared, tabled
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import Estimate

#: Width in characters from which all columns are shown.
WIDE = 110
#: The same with a column for the ratio to a policy that knows the map.
WIDEST = 135
#: Width of an additional time, and of the column for the ratio to the lower bound.
TIME_WIDTH, BOUND_WIDTH = 22, 22


def headings(levels: Sequence[CoverageThreshold]) -> list[str]:
    """Return the columns of scenarios with these thresholds: times, success, failures, AUC and decision time."""
    times = [f"{CoverageThreshold(key).title} [steps]" for key in tabled(levels)]
    level = shared(levels)
    return [*times, f"{level.percent} reached" if level else "reached", "failed", "AUC", "decision p50"]


def short_headings(levels: Sequence[CoverageThreshold]) -> list[str]:
    """Return the short headings of a narrow table: times and success."""
    level = shared(levels)
    return [*(CoverageThreshold(key).title for key in tabled(levels)), level.percent if level else "reached"]


def headline_table(results: Results, width: int = WIDE, *, notes: bool = True) -> Table:
    """Return one row per scenario and policy: T90 and T99 with interval, success; failures, AUC and latency.

    The last three are left out where lines have less than :data:`WIDE` characters. Where a policy that knows the map
    flew the same tasks, the last column is the mean ratio of steps to it. Success and ratio are about the threshold of
    the scenario, which has a column too; times above the goal of a scenario are a dash. The ratio to the lower bound,
    which is known for T99, is in front of it where there is room. Without ``notes`` nothing stands below.
    """
    known, levels = reference_of(results), results.levels
    level, times = shared(levels), tabled(levels)
    wide = (WIDEST if known else WIDE) + TIME_WIDTH * (len(times) - 2)
    shown = headings(levels) if width >= wide else short_headings(levels)
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, caption_justify="left")
    table.add_column("policy", overflow="fold", min_width=min(30, max(map(len, results.policies), default=0)))
    for heading in shown:
        table.add_column(heading, justify="right", no_wrap=True)
    to_bound = level == T99 and width >= wide + BOUND_WIDTH
    if to_bound:
        table.add_column("T99 / bound", justify="right", no_wrap=True)
    if known:
        table.add_column(f"{level.title if level else 'steps'} / {known}", justify="right", no_wrap=True)
    lines = footnotes(results, [policy for _, policy in results.groups], times=width >= wide)
    lines += [BOLD] if len(results.policies) - len(results.privileged_policies) > 1 else []
    bounds: set[str] = set()
    for scenario in results.scenarios:
        name = results.title(scenario)
        if len(results.scenarios) > 1 or name != scenario:
            name = name if level else f"{name} ({results.level(scenario).title})"
            table.add_row(Text(name, "bold"))
        comparison = Comparison(results.on_common_tasks, scenario)
        lines += missing_episodes(results, scenario) + _notes(comparison, named=len(results.scenarios) > 1)
        best = {key: shown_best(comparison, key) for key in comparison.level.times}
        best["auc"] = shown_best(comparison, "auc", lower_is_better=False)
        for policy in comparison.groups:
            ratio = [Text(_ratio(ratio_to_bound(comparison, policy)))] if to_bound else []
            ratio += [Text(_ratio(ratio_to_reference(comparison, policy)))] if known else []
            bounds |= {each.plain[:1] for each in ratio} & {">", "<"}
            table.add_row(*_row(comparison, policy, times, best)[: 1 + len(shown)], *ratio)
        table.add_section()
    lines += [f"{' and '.join(sorted(bounds))}: a bound, as some episodes never reached it."] if bounds else []
    table.caption = "\n".join(lines if notes else ()) or None
    return table


def _notes(comparison: Comparison, named: bool) -> list[str]:
    """Return the lines below the table about one scenario, which they name where there are several."""
    text = " ".join(scenario_notes(comparison)) if comparison.groups else ""
    return [f"{comparison.scenario}: {text}" if named else text] if text else []


def reference_of(results: Results) -> str | None:
    """Return the first policy that knows the map and flew a task: the baseline of ratios of steps."""
    return next(
        (name for name in results.privileged_policies if any(policy == name for _, policy in results.groups)), None
    )


def _row(comparison: Comparison, policy: str, times: Sequence[str], best: Mapping[str, Sequence[str]]) -> list[Text]:
    failures = len(failed(comparison.groups[policy]))
    return [
        _name(comparison, policy),
        *(
            Text(_steps(comparison.estimate(policy, key)), "bold" if policy in best.get(key, ()) else "")
            for key in times
        ),
        Text(percent(comparison.reached(policy))),
        Text(str(failures), "bold red" if failures else ""),
        Text(fixed(comparison.estimate(policy, "auc").mean, 3), "bold" if policy in best["auc"] else ""),
        Text(decision_time(comparison, policy)),
    ]


def _name(comparison: Comparison, policy: str) -> Text:
    failures, name = failed_of(comparison, policy), marked(comparison.results, policy)
    if failures:
        return Text(f"{name} (failed {failures.replace(' of ', '/')})", "red")
    return Text(name, "dim" if comparison.privileged(policy) else "")


def decision_time(comparison: Comparison, policy: str) -> str:
    """Return the median decision time of a policy, marked if it is a share of a batch's."""
    shown = latency(comparison.estimate(policy, "latency_p50_us").mean)
    return f"{shown} ({BATCH_SHARE})" if policy in comparison.results.batched_policies else shown


def ratio_to_reference(comparison: Comparison, policy: str) -> tuple[str, Estimate] | None:
    """Return the mean ratio of a policy's steps to those of the reference, and its sign.

    The sign is that of a bound, or empty. There is no ratio for a policy that knows the map, and where none is known.
    """
    estimate, bound = comparison.to_reference(policy), comparison.reference_censoring(policy).bound
    if comparison.privileged(policy) or math.isnan(estimate.mean) or bound is None:
        return None
    return bound, estimate


def ratio_to_bound(comparison: Comparison, policy: str) -> tuple[str, Estimate] | None:
    """Return the mean ratio of T99 to its lower bound, and its sign: ``>`` where some episodes never got there."""
    estimate = comparison.estimate(policy, "t99_to_bound")
    if math.isnan(estimate.mean):
        return None
    return ("" if comparison.success(policy).mean == 1 else ">"), estimate


def _ratio(ratio: tuple[str, Estimate] | None) -> str:
    if ratio is None:
        return ""
    bound, estimate = ratio
    return f"{bound} {fixed(estimate.mean, 2)}" if bound else with_interval(estimate, 2)


def _steps(estimate: Estimate) -> str:
    return with_interval(estimate, decimals_for(estimate.mean))


def latency(microseconds: float) -> str:
    """Format a time with a suitable unit."""
    if math.isnan(microseconds):
        return fixed(None, 0)
    for unit, size in (("s", 1e6), ("ms", 1e3)):
        if microseconds >= size:
            return f"{fixed(microseconds / size, 1)} {unit}"
    return f"{fixed(microseconds, 0)} µs"
