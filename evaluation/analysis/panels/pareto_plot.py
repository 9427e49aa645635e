"""Pareto plot: area under the coverage curve against the time of a decision."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.outliers import far_behind
from indoor_explorers.evaluation.analysis.panels.plot_data import Guide, Plot, PlotAxis, PlotSeries
from indoor_explorers.evaluation.drawing.formatting import fixed, with_interval
from indoor_explorers.evaluation.drawing.palette import PolicyStyle, Styles
from indoor_explorers.evaluation.statistics import FEWEST, Estimate


class ParetoPoint(NamedTuple):
    """One policy in the plot."""

    policy: str
    median: float
    """Mean over episodes of the median decision time in milliseconds."""
    late: float
    """The same of the 99th percentile."""
    area: Estimate
    """The AUC."""
    front: bool
    """Whether it is on the Pareto front: no other ranked policy is as fast and as good, and better in one of these."""


def pareto_points(comparison: Comparison) -> list[ParetoPoint]:
    """Return the policies whose latency and AUC were measured, fastest first."""
    found = []
    for policy in comparison.ranking:
        median, late = (comparison.estimate(policy, f"latency_{which}_us").mean / 1000 for which in ("p50", "p99"))
        area = comparison.estimate(policy, "auc")
        if median > 0 and not math.isnan(area.mean):
            found.append(ParetoPoint(policy, median, max(median, late), area, front=False))
    rivals = [each for each in found if each.policy in comparison.ranked_policies]
    leading = [each for each in rivals if not any(_beats(other, each) for other in rivals)]
    return [
        each._replace(front=each in leading) for each in sorted(found, key=lambda each: (each.median, -each.area.mean))
    ]


def _beats(one: ParetoPoint, other: ParetoPoint) -> bool:
    no_worse = one.median <= other.median and one.area.mean >= other.area.mean
    return no_worse and (one.median < other.median or one.area.mean > other.area.mean)


def pareto_plot(comparison: Comparison, styles: Styles) -> Plot | None:
    """Return the plot; None when fewer than two policies can be drawn."""
    found = pareto_points(comparison)
    if len(found) < 2:
        return None
    front = [each for each in found if each.front]
    far = far_behind(comparison)
    near = [each for each in found if each.policy not in far] or found
    slowest, fastest = max(each.late for each in near), min(each.median for each in near)
    areas = [end for each in near for end in each.area if end is not None]
    margin = max(0.004, 0.06 * (max(areas) - min(areas)))
    # The front is a staircase: what a policy reaches, it also reaches with more time.
    stairs_x, stairs_y = [each.median for each in front] + [slowest * 2], [each.area.mean for each in front]
    return Plot(
        title="AUC against the time of a decision",
        label="AUC of each policy against its decision latency, the Pareto front marked",
        x=PlotAxis(title="time of a decision [ms]", low=fastest / 1.6, high=slowest * 1.6, log=True),
        y=PlotAxis(title="AUC", low=max(0.0, min(areas) - margin), high=max(areas) + margin),
        series=[_point(comparison, each, styles[each.policy]) for each in found],
        guides=[Guide(name="Pareto front", x=stairs_x, y=[*stairs_y, stairs_y[-1]], step=True)],
        beyond=_beyond([each for each in found if each not in near]),
    )


def _beyond(points: Sequence[ParetoPoint]) -> str:
    """Name the policies that the range leaves out, as they are far behind."""
    listed = "; ".join(
        f"{each.policy}, AUC {with_interval(each.area, 3)} at {_milliseconds(each.median)}" for each in points
    )
    return f"Out of range: {listed}." if listed else ""


def _point(comparison: Comparison, point: ParetoPoint, style: PolicyStyle) -> PlotSeries:
    low, high = point.area.low, point.area.high
    few = len(comparison.groups[point.policy]) < FEWEST
    areas = comparison.results.values(comparison.scenario, point.policy, "auc").tolist()
    return PlotSeries(
        name=point.policy,
        style=style,
        x=[point.median],
        y=[point.area.mean],
        low=None if low is None else [low],
        high=None if high is None else [high],
        right=[point.late],
        dots=[(point.median, area) for area in areas] if few else None,
        hollow=[not point.front],
        line=False,
        text=[
            f"AUC {with_interval(point.area, 3)}, p50 {_milliseconds(point.median)}, "
            f"p99 {_milliseconds(point.late)}" + (", on the front" if point.front else "")
        ],
    )


def _milliseconds(value: float) -> str:
    return f"{fixed(value, 3 if value < 1 else 1)} ms"
