"""Bars of a reported policy beside the flown ones, over the tasks of both where there are any."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.reported import ReportedFigures, reported_on
from indoor_explorers.evaluation.analysis.tables.reported_table import metric_title
from indoor_explorers.evaluation.drawing.formatting import counted, decimals_for
from indoor_explorers.evaluation.drawing.palette import PolicyStyle, Styles, styles_beside
from indoor_explorers.evaluation.statistics import Estimate, bootstrap_mean


class Bar(NamedTuple):
    """The mean of one policy."""

    name: str
    estimate: Estimate
    style: PolicyStyle
    reported: bool
    """Whether it was not flown here, so that its bar is hatched."""


@dataclass(frozen=True)
class ReportedChart:
    """One metric of a reported policy and the flown ones."""

    title: str
    """The metric with its unit."""
    over: str
    """What the means are over."""
    bars: list[Bar]
    """The flown policies, then the reported one."""
    decimals: int
    note: str
    """Where the reported figures come from."""

    @property
    def most(self) -> float:
        """The largest value that is drawn."""
        return max(end for bar in self.bars for end in bar.estimate if end is not None)


def reported_charts(comparison: Comparison, styles: Styles) -> list[ReportedChart]:
    """Return a chart for each reported policy and metric of a scenario that flown policies have too."""
    beside = styles_beside(styles, [policy.name for policy in comparison.results.reported])
    return [
        chart
        for figures in reported_on(comparison)
        for metric in figures.metrics
        if (chart := _chart(figures, metric, styles, beside[figures.policy.name])).bars[1:] and chart.most > 0
    ]


def _chart(figures: ReportedFigures, metric: str, styles: Styles, style: PolicyStyle) -> ReportedChart:
    return ReportedChart(
        metric_title(metric),
        f"over the {counted(figures.tasks, 'task')} of both" if figures.tasks else "over different tasks",
        [bar for bar in _bars(figures, metric, styles, style) if bar.estimate.mean == bar.estimate.mean],
        3 if metric.startswith("auc") else decimals_for(figures.estimate(metric).mean),
        figures.note,
    )


def _bars(figures: ReportedFigures, metric: str, styles: Styles, style: PolicyStyle) -> Iterator[Bar]:
    own = figures.estimate(metric)
    for policy in figures.comparison.groups:
        pairs, mean = figures.pairs(policy, metric), figures.comparison.estimate(policy, metric)
        if figures.tasks:
            mean, own = (bootstrap_mean(each, maps=pairs.maps) for each in (pairs.flown, pairs.reported))
        yield Bar(policy, mean, styles[policy], False)
    yield Bar(figures.name, own, style, True)
