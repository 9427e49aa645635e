"""Figures of one scenario for print: coverage curves, and times to a coverage threshold as dots with intervals."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.coverage_axes import coverage_at, focus_step, sampled_steps
from indoor_explorers.evaluation.analysis.facts import denominator
from indoor_explorers.evaluation.analysis.outliers import near_groups
from indoor_explorers.evaluation.drawing.formatting import span
from indoor_explorers.evaluation.drawing.palette import PolicyStyle, Styles, crowded
from indoor_explorers.evaluation.drawing.print_style import PAGE, percent_axis, plain, strokes
from indoor_explorers.evaluation.exports.figures.layout import add_legend, add_note, paper
from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS, MEASURES
from indoor_explorers.evaluation.statistics import FEWEST, curve_band


def _label(comparison: Comparison, policy: str) -> str:
    return plain(policy) + (" (knows the map)" if comparison.privileged(policy) else "")


def coverage_figure(comparison: Comparison, styles: Styles) -> Figure:
    """Draw mean coverage by step with 95 % bands, up to where curves hardly change."""
    labels = [_label(comparison, policy) for policy in comparison.groups]
    figure = paper(PAGE, 3.1, labels)
    axes = figure.add_subplot()
    steps = sampled_steps(comparison, 400)
    limit = focus_step(comparison)
    banded = not crowded(len(comparison.groups))
    for policy in comparison.groups:
        _curve(axes, comparison, policy, steps, limit, styles[policy], banded)
    shares = [LEVELS[key] for key in comparison.level.times]
    for share in shares:
        axes.axhline(share, color="#999999", linewidth=0.6, linestyle=(0, (1, 2)), zorder=0)
    axes.set(xlim=(0, limit), ylim=(0, 1.01), xlabel="step", title=plain(comparison.title, 70))
    settings = comparison.results.scenarios[comparison.scenario]
    axes.set_ylabel("coverage of the team:\n" + denominator(settings).replace("free cells ", "free cells\n"))
    axes.set_yticks(sorted({0, 0.25, 0.5, 0.75, *shares}))
    percent_axis(axes.yaxis)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    add_legend(figure, list(comparison.groups), styles, labels)
    _footnote(figure, comparison, "" if banded else " are left out, as they would overlap")
    return figure


def _curve(
    axes: Axes, comparison: Comparison, policy: str, steps: np.ndarray, limit: int, style: PolicyStyle, banded: bool
) -> None:
    """Draw one policy's mean coverage at (T,) steps, with markers at other steps than the other policies'."""
    mean, low, high = curve_band(coverage_at(comparison.groups[policy], steps), maps=comparison.maps(policy))
    if banded and not np.isnan(low).any():
        axes.fill_between(steps, low, high, color=style.hex, alpha=0.16, linewidth=0)
    visible = max(1, int((steps <= limit).sum()))
    every = (style.marker * visible // 40 % max(1, visible // 6), max(1, visible // 6))
    axes.plot(steps, mean, markevery=every, **strokes(style))


def times_figure(comparison: Comparison, styles: Styles) -> Figure:
    """Draw T90 and the time to the threshold of each policy, best at the top, above the dots of its episodes."""
    ranked = comparison.ranking
    figure = paper(PAGE, 0.8 + 0.24 * len(ranked))
    times = comparison.level.times
    (row,) = figure.subplots(1, len(times), sharey=True, squeeze=False)
    for axes, metric in zip(row, times, strict=True):
        most = _most(comparison, metric)
        for place, policy in enumerate(ranked):
            _time(axes, comparison, policy, metric, place, styles[policy])
            _beyond(axes, comparison, policy, metric, place, styles[policy], most)
        axes.set(xlabel=f"{MEASURES[metric].title} [steps]", ylim=(len(ranked) - 0.4, -0.6))
        axes.set_xlim(0, most)
        axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
        axes.grid(axis="x", color="#e3e3e3", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.tick_params(axis="y", length=0)
        axes.spines["left"].set_visible(False)
    row[0].set_yticks(range(len(ranked)), [_label(comparison, policy) for policy in ranked])
    row[0].set_title(plain(comparison.title, 70))
    _footnote(figure, comparison, "; hollow dots: threshold not reached")
    return figure


def _most(comparison: Comparison, metric: str) -> float:
    """Return the end of the axis of a time: a little more than the longest of those that are not far behind."""
    near = [comparison.results.values(comparison.scenario, policy, metric) for policy in near_groups(comparison)]
    return 1.05 * max(1.0, *(float(values.max()) for values in near))


def _beyond(
    axes: Axes, comparison: Comparison, policy: str, metric: str, place: int, style: PolicyStyle, most: float
) -> None:
    """Draw an arrowhead at the edge and the figure beside it for a mean beyond the axis."""
    mean = comparison.estimate(policy, metric).mean
    if mean > most:
        axes.plot([most], [place], marker=">", markersize=5, color=style.hex, clip_on=False)
        beside: dict[str, Any] = {"xytext": (-6, 0), "textcoords": "offset points", "ha": "right", "va": "center"}
        axes.annotate(f"{mean:.0f}", (most, place), fontsize=7, **beside)


def _time(axes: Axes, comparison: Comparison, policy: str, metric: str, place: int, style: PolicyStyle) -> None:
    values = comparison.results.values(comparison.scenario, policy, metric)
    estimate = comparison.estimate(policy, metric)
    missed = np.array([record.metrics.get(metric) is None for record in comparison.groups[policy]])
    dots: dict[str, Any] = {"s": 7, "color": style.hex, "alpha": 0.4, "linewidths": 0.5}
    below = place + 0.2
    axes.scatter(values[~missed], np.full(int((~missed).sum()), below), marker="o", **dots)
    axes.scatter(values[missed], np.full(int(missed.sum()), below), marker="o", facecolors="none", **_rim(dots))
    if estimate.low is not None and estimate.high is not None:
        axes.plot([estimate.low, estimate.high], [place - 0.12] * 2, color=style.hex, linewidth=1.6)
    axes.plot([estimate.mean], [place - 0.12], **strokes(style) | {"markersize": 5.2})


def _rim(dots: dict[str, Any]) -> dict[str, Any]:
    return {("edgecolors" if key == "color" else key): value for key, value in dots.items()}


def _footnote(figure: Figure, comparison: Comparison, more: str = "") -> None:
    """Write a note below the figure that says what it shows."""
    counts = [len(records) for records in comparison.groups.values()]
    how = "95 % bootstrap intervals" if min(counts) >= FEWEST else "too few for intervals"
    add_note(figure, f"Means over {span(counts)} episode{'' if max(counts) == 1 else 's'} a policy, {how}{more}.")
