"""The table of steps to the threshold compared with the best-ranked policy."""

from __future__ import annotations

import math
from dataclasses import dataclass

from markupsafe import Markup

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.failures import failed_of
from indoor_explorers.evaluation.drawing.dot_plots import Scale, difference_dot_plot, difference_scale
from indoor_explorers.evaluation.drawing.formatting import (
    EN_DASH,
    counted,
    fixed,
    interval,
    p_value,
    percent,
    with_interval,
)
from indoor_explorers.evaluation.drawing.palette import PolicyStyle, Styles
from indoor_explorers.evaluation.drawing.table import Cell
from indoor_explorers.evaluation.statistics import Contrast, Estimate, Finding, WinTieLoss


@dataclass(frozen=True)
class ContrastRow:
    """One policy compared with the best-ranked one."""

    policy: str
    difference: Cell
    """Mean difference; without a value where both finished no task."""
    dot_plot: Markup
    better: Cell
    """Probability that it needs fewer steps on a task."""
    tally: WinTieLoss
    p: str
    effect: str
    verdict: str


def contrast_table(comparison: Comparison, styles: Styles) -> list[ContrastRow]:
    """Return a row for every policy but the best-ranked; empty where policies did not fly the same tasks."""
    differences = [contrast.difference for contrast in comparison.contrasts.values()]
    scale = difference_scale([each for each in differences if not math.isnan(each.mean)])
    return [
        _row(comparison, policy, contrast, scale, styles[policy]) for policy, contrast in comparison.contrasts.items()
    ]


def _row(comparison: Comparison, policy: str, contrast: Contrast, scale: Scale, style: PolicyStyle) -> ContrastRow:
    few, none = contrast.difference.low is None, math.isnan(contrast.difference.mean)
    drawn = comparison.differences(policy), contrast.difference, scale, style
    return ContrastRow(
        policy=policy,
        difference=Cell(with_interval(contrast.difference, sign=True), None if none else contrast.difference.mean),
        dot_plot=Markup("") if none else difference_dot_plot(*drawn),
        better=Cell(percent(contrast.improvement.mean), detail=_percents(contrast.improvement)),
        tally=contrast.tally,
        p=EN_DASH if few else p_value(contrast.adjusted_p).removeprefix("= "),
        effect=EN_DASH if few else fixed(contrast.effect_size, 2, sign=True),
        verdict="; ".join(filter(None, (reading(contrast), _success(comparison, policy), _failed(comparison, policy)))),
    )


def _success(comparison: Comparison, policy: str) -> str:
    """Say whether the policy is shown to reach the threshold more or less often than the best-ranked."""
    if not comparison.success_differs(policy):
        return ""
    less = comparison.reached(policy) < comparison.reached(comparison.ranked_policies[0])
    p = p_value(comparison.success_p_values[policy])
    return f"reached {'less' if less else 'more'} often (p {p})"


def _failed(comparison: Comparison, policy: str) -> str:
    return f"failed in {failed}" if (failed := failed_of(comparison, policy)) else ""


def _percents(estimate: Estimate) -> str:
    if estimate.low is None or estimate.high is None:
        return ""
    return interval(Estimate(100 * estimate.mean, 100 * estimate.low, 100 * estimate.high), 0)


def reading(contrast: Contrast) -> str:
    """Return what is shown of the times in a few words; if nothing is, how many maps or tasks would resolve it."""
    if contrast.difference.low is None:
        return "too few episodes that both finished" if contrast.both < contrast.pairs else "too few episodes"
    if contrast.shown:
        word = "slower" if contrast.difference.mean > 0 else "faster"
        less = f" by less than {margin(contrast)}" if contrast.equivalent else ""
        more = contrast.finished[0] - contrast.finished[1]
        mixed = f", but finished {abs(more)} {'more' if more > 0 else 'fewer'}" * (contrast.finding is Finding.MIXED)
        return f"{word}{less}{where_both_finished(contrast)}{mixed}"
    if contrast.finding is Finding.AS_GOOD:
        return f"as good within {margin(contrast)}{where_both_finished(contrast)}"
    if contrast.finding is not Finding.OPEN:
        return ""  # what is shown is that one succeeds more often
    return f"not {'resolved' if contrast.margin else 'significant'} ({missing(contrast)})"


def where_both_finished(contrast: Contrast) -> str:
    """Say over which tasks times are compared; empty where both policies finished all."""
    if contrast.both == contrast.pairs:
        return ""
    return f" over the {contrast.both} of {contrast.pairs} tasks that both finished"


def margin(contrast: Contrast) -> str:
    """Return the margin of equivalence as a percentage."""
    return percent(contrast.margin, 0 if round(100 * contrast.margin, 6).is_integer() else 1)


def missing(contrast: Contrast) -> str:
    """Say how many maps or tasks would resolve it, or else what difference would have been seen."""
    units = "maps" if contrast.over_maps and contrast.maps < contrast.pairs else "tasks"
    if contrast.needed == contrast.needed:
        return f"about {counted(int(contrast.needed), units.removesuffix('s'))} would"
    if math.isinf(contrast.detectable):
        return f"too few {units} to detect any"
    return f"detectable: {fixed(contrast.detectable, 1)} steps"
