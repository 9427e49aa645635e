"""Rows of the Markdown and LaTeX tables: the figures of the terminal's table, each with its interval."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.facts import denominator
from indoor_explorers.evaluation.analysis.failures import failed
from indoor_explorers.evaluation.analysis.notes import narrow_notes, scenario_notes
from indoor_explorers.evaluation.analysis.shown_best import BOLD, shown_best
from indoor_explorers.evaluation.analysis.tables.headline_table import (
    decision_time,
    headings,
    ratio_to_bound,
    ratio_to_reference,
    reference_of,
)
from indoor_explorers.evaluation.analysis.tables.policy_names import footnotes, marked
from indoor_explorers.evaluation.analysis.tables.ratio_table import bounded
from indoor_explorers.evaluation.drawing.formatting import counted, fixed, interval, percent, percent_interval
from indoor_explorers.evaluation.harness.results.coverage_threshold import T99, CoverageThreshold, tabled
from indoor_explorers.evaluation.statistics import CONFIDENCE, FEWEST


@dataclass(frozen=True)
class ExportCell:
    """One figure."""

    text: str
    interval: str = ""
    """``[low, high]``; empty where there is none."""
    best: bool = False
    """Whether it is significantly better than that of every other policy."""


@dataclass(frozen=True)
class ExportRow:
    """The figures of one policy, in the order of :func:`table_headings`."""

    policy: str
    """Its name, marked where it knows the map or reads the settings of the maps' generator."""
    cells: tuple[ExportCell, ...]


def table_rows(comparison: Comparison) -> list[ExportRow]:
    """Return a row for each policy, in the experiment's order."""
    metrics = (*comparison.level.times, "auc")
    best = {metric: shown_best(comparison, metric, lower_is_better=metric != "auc") for metric in metrics}
    return [
        ExportRow(marked(comparison.results, policy), _cells(comparison, policy, best)) for policy in comparison.groups
    ]


def table_headings(comparison: Comparison) -> list[str]:
    """Return the columns after a policy's name: those of the terminal's table at its widest."""
    known, level = _reference(comparison), comparison.level
    ratios = [*(["T99 / bound"] if level == T99 else []), *([f"{level.title} / {known}"] if known else [])]
    return headings([level]) + ratios


def _reference(comparison: Comparison) -> str | None:
    return reference_of(comparison.results) if comparison.results.references.get(comparison.scenario) else None


def _ratios(comparison: Comparison, policy: str) -> Iterator[ExportCell]:
    """Yield the ratios to the lower bound and to the policy that knows the map, as far as the table has them."""
    ratios = [ratio_to_bound(comparison, policy)] if comparison.level == T99 else []
    ratios += [ratio_to_reference(comparison, policy)] if _reference(comparison) else []
    for ratio in ratios:
        sign, estimate = ratio or ("", None)
        shown = interval(estimate, 2) if estimate and not sign else ""
        yield ExportCell(bounded(fixed(estimate.mean, 2), sign) if estimate else "", shown)


def _cells(comparison: Comparison, policy: str, best: dict[str, list[str]]) -> tuple[ExportCell, ...]:
    *times, auc = (
        replace(_measured(comparison, policy, metric, decimals), best=policy in best.get(metric, []))
        for metric, decimals in (*((key, 1) for key in tabled([comparison.level])), ("auc", 3))
    )
    success = comparison.success(policy)
    reached = ExportCell(percent(success.mean), percent_interval(success))
    failures = ExportCell(str(len(failed(comparison.groups[policy]))))
    return *times, reached, failures, auc, ExportCell(decision_time(comparison, policy)), *_ratios(comparison, policy)


def _measured(comparison: Comparison, policy: str, metric: str, decimals: int) -> ExportCell:
    estimate = comparison.estimate(policy, metric)
    return ExportCell(fixed(estimate.mean, decimals), interval(estimate, decimals))


def caption(comparison: Comparison) -> list[str]:
    """Return the sentences that explain a table's figures."""
    counts = [len(records) for records in comparison.groups.values()]
    span = counted(counts[0], "episode") if len(set(counts)) == 1 else f"{min(counts)} to {max(counts)} episodes"
    budgets = sorted({record.budget for record in comparison.records})
    limit = f"{budgets[0]}" if len(budgets) == 1 else f"{budgets[0]} to {budgets[-1]}"
    settings = comparison.results.scenarios[comparison.scenario]
    return [
        f"{span} of each policy on {_maps(comparison)}{_of_suite(comparison)}.",
        _interval_kind(comparison, min(counts)),
        f"Coverage is the {denominator(settings)}.",
        f"{_times(comparison.level)}; an episode that never reaches it counts as its budget of {limit} steps.",
        *(["A dash: the goal of this scenario is below that threshold."] if comparison.level != T99 else []),
        *([BOLD] if len(comparison.ranked_policies) > 1 else []),
        *scenario_notes(comparison),
        *narrow_notes(comparison),
        *(["Policies that know the map are not ranked."] if any(map(comparison.privileged, comparison.groups)) else []),
        *footnotes(comparison.results, comparison.groups),
    ]


def _maps(comparison: Comparison) -> str:
    """Return the number of maps, and of buildings where some have several maps."""
    maps = counted(comparison.map_count, "map")
    several = comparison.building_count < comparison.map_count
    return f"{maps} of {counted(comparison.building_count, 'building')}" if several else maps


def _of_suite(comparison: Comparison) -> str:
    run = comparison.results.suite_run
    return f"; {', '.join(run.phrases)}" if run else ""


def _times(level: CoverageThreshold) -> str:
    """Define the times of the scenario's thresholds."""
    levels = [CoverageThreshold(key) for key in level.times]
    titles, shares = (" and ".join(words) for words in zip(*((e.title, e.percent) for e in levels), strict=True))
    return f"{titles} {'are the first steps' if len(levels) > 1 else 'is the first step'} with {shares} coverage"


def _interval_kind(comparison: Comparison, fewest: int) -> str:
    if fewest < FEWEST:
        return f"Means; fewer than {FEWEST} episodes get no interval."
    few = "this map alone" if comparison.map_count == 1 else "these maps alone"
    scope = "maps like these" if comparison.over_maps else few
    return f"Means with their {percent(CONFIDENCE)} bootstrap intervals over {scope}; shares reached with exact ones."
