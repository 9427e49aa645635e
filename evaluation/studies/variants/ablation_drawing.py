"""The figure of an ablation: differences of the variants to the full one, and some learning curves."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullLocator
from numpy.typing import NDArray

from indoor_explorers.evaluation.drawing.formatting import span
from indoor_explorers.evaluation.drawing.palette import COLOURS, PolicyStyle, policy_styles
from indoor_explorers.evaluation.drawing.print_style import (
    grid_below,
    legend_beside,
    plain,
    print_style,
    save,
    sheet,
    strokes,
)
from indoor_explorers.evaluation.studies.variants.scoring import VariantScore

#: Number of learning curves besides the full variant's; the variants that differ most are drawn.
CURVES = 4
#: An axis is linear up to NEAR steps, and logarithmic beyond if a difference is larger than FAR x NEAR.
NEAR, FAR = 10.0, 8.0
#: Ticks of such an axis, on both sides of 0.
TICKS = (5, 10, 30, 100, 300, 1000)
#: Height of the learning curves and of the gap above them, in inches.
LEARNING, GAP = 2.0, 0.95
GREY, DOT = "#666666", "#222222"


def write_figure(found: Sequence[VariantScore], scenario: str, folder: Path) -> Path:
    """Write the figure as SVG, PNG and PDF, and return the path of the PNG."""
    folder.mkdir(parents=True, exist_ok=True)
    with print_style():
        paths = save(ablation_figure(found, scenario), folder, "ablation")
    return next(path for path in paths if path.suffix == ".png")


def ablation_figure(found: Sequence[VariantScore], scenario: str) -> Figure:
    """Draw differences in T99 and T90, the smallest T99 on top, and learning curves below."""
    full = found[0]
    ranked = sorted(found, key=lambda each: each.against(full, "t99").mean)
    heights = [0.22 * len(found) + 0.3, LEARNING]
    figure = sheet(8.2, sum(heights) + GAP)
    share = GAP / (sum(heights) / 2)
    grid = figure.add_gridspec(2, 1, height_ratios=heights, hspace=share, top=1.0, bottom=0.0)
    panels = grid[0].subgridspec(1, 2, wspace=0.06).subplots(sharey=True, squeeze=False)[0]
    for axes, metric, title in zip(panels, ("t99", "t90"), ("T99", "T90"), strict=True):
        _differences(axes, ranked, full, metric)
        _scale(axes, ranked, full, metric)
        axes.set_xlabel(f"{title} less that of {full.variant} ({full.mean(metric).mean:.1f}) [steps]")
    panels[0].set_yticks(range(len(ranked)), [plain(variant.variant) for variant in ranked])
    panels[0].set_title(f"What each ingredient is worth on {plain(scenario)}", pad=14)
    _note(panels[0], _made_of(found), above=True)
    axes = figure.add_subplot(grid[1])
    _learning(axes, [full, *_far_apart(ranked, full)])
    return figure


def _made_of(found: Sequence[VariantScore]) -> str:
    seeds = span(len(variant.seeds) for variant in found)
    maps = found[0].times["t99"].shape[1]
    return f"Means over {seeds} trainings, a dot each, on {maps} unseen maps; 95 % intervals over both."


def _note(axes: Axes, text: str, *, above: bool = False) -> None:
    place = (0, 4) if above else (0, -36)
    axes.annotate(
        text,
        (0, 1 if above else 0),
        place,
        xycoords="axes fraction",
        textcoords="offset points",
        fontsize=7,
        color=GREY,
        va="bottom" if above else "top",
        annotation_clip=False,
    )


def _differences(axes: Axes, ranked: Sequence[VariantScore], full: VariantScore, metric: str) -> None:
    """Draw a row for each variant: its interval, its mean and its trainings."""
    axes.axvline(0.0, color="#444444", linewidth=0.8)
    for place, variant in enumerate(ranked):
        estimate = variant.against(full, metric)
        dots = variant.dots(full, metric)
        axes.scatter(dots, np.full(len(dots), place + 0.28), s=6, color=DOT, alpha=0.6, linewidths=0, zorder=2)
        if variant is full:
            continue
        colour = _hue(estimate.low, estimate.high)
        if estimate.low is not None and estimate.high is not None:
            axes.plot([estimate.low, estimate.high], [place, place], color=colour, linewidth=1.5, zorder=3)
        axes.plot([estimate.mean], [place], color=colour, marker="D", markersize=4.2, zorder=4)
    axes.set_ylim(len(ranked) - 0.4, -0.6)
    grid_below(axes)
    axes.tick_params(axis="y", length=0)


def _scale(axes: Axes, ranked: Sequence[VariantScore], full: VariantScore, metric: str) -> None:
    """Make an axis logarithmic far from 0 if a variant differs very much."""
    far = max(abs(variant.against(full, name).mean) for variant in ranked for name in ("t99", "t90"))
    if far > FAR * NEAR:
        low, high = axes.dataLim.intervalx
        axes.set_xscale("symlog", linthresh=NEAR, linscale=1.0)
        axes.set_xlim(min(1.5 * low, -1.0), max(1.5 * high, 1.0))
        axes.set_xticks([0, *(sign * tick for sign in (-1, 1) for tick in TICKS if low <= sign * tick <= high)])
        axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:+g}" if value else "0"))


def _hue(low: float | None, high: float | None) -> str:
    """Return vermillion for more steps than the full one, blue for fewer, grey if the interval contains 0."""
    if low is None or high is None or low <= 0.0 <= high:
        return GREY
    return COLOURS[1 if low > 0 else 0][0]


def _far_apart(ranked: Sequence[VariantScore], full: VariantScore) -> list[VariantScore]:
    """Return the variants that differ most from the full one, in the order given."""
    others = [variant for variant in ranked if variant is not full]
    most = sorted(others, key=lambda each: -abs(each.against(full, "t99").mean))[:CURVES]
    return [variant for variant in others if variant in most]


def _learning(axes: Axes, shown: Sequence[VariantScore]) -> None:
    """Draw the mean steps to the goal by moves made, with a band over the trainings."""
    styles = policy_styles(variant.variant for variant in shown)
    for variant in shown:
        if all(curve.shape[1] for curve in variant.curves):
            _curve(axes, variant, styles[variant.variant])
    axes.set(yscale="log", xlabel="moves made in training", ylabel="mean steps to the goal")
    axes.set_title("How they learn: greedy evaluations, apart from training", fontsize=8.5)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / 1e3:,.0f}k" if value else "0"))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_locator(NullLocator())
    low, high = axes.get_ylim()
    ticks = [tick for tick in (10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 600, 1000) if low <= tick <= high]
    axes.set_yticks(ticks)
    grid_below(axes)
    legend_beside(axes, 1.01)
    _note(axes, "Lines: means of the trainings; bands: from the best to the worst of them.")


def _curve(axes: Axes, variant: VariantScore, style: PolicyStyle) -> None:
    moves, values = on_one_grid(variant.curves)
    label = plain(variant.variant)
    axes.plot(moves, values.mean(axis=0), **strokes(style) | {"marker": "", "label": label})
    axes.fill_between(moves, values.min(axis=0), values.max(axis=0), color=style.hex, alpha=0.15, linewidth=0)


def on_one_grid(curves: Sequence[NDArray[np.float64]]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return moves (K,) and values (S, K) of S curves (2, K'), interpolated linearly where all of them have values."""
    first, last = max(curve[0, 0] for curve in curves), min(curve[0, -1] for curve in curves)
    moves = np.unique(np.concatenate([curve[0] for curve in curves]).clip(first, last))
    return moves, np.stack([np.interp(moves, curve[0], curve[1]) for curve in curves])
