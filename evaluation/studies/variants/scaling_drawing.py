"""The figure of a scaling study: T90 and T99 over each axis, a dot for each training."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullLocator
from numpy.typing import NDArray

from indoor_explorers.evaluation.drawing.formatting import span
from indoor_explorers.evaluation.drawing.palette import COLOURS
from indoor_explorers.evaluation.drawing.print_style import grid_below, plain, print_style, save, sheet
from indoor_explorers.evaluation.studies.variants.scoring import VariantScore

Levels = Mapping[float, VariantScore]

#: Width and height of a panel, and the gap between panels, in inches.
WIDTH, HEIGHT, GAP = 2.6, 2.4, 0.25
#: Colour and marker of each time.
STYLES = {"t99": (COLOURS[0][0], "o"), "t90": (COLOURS[1][0], "s")}
#: Candidates for the ticks of steps.
TICKS = (10, 15, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 600, 800, 1000, 1500, 2000)
GREY = "#666666"


def write_figure(found: Mapping[str, Levels], scenario: str, folder: Path) -> Path:
    """Write the figure of the axes with several levels as SVG, PNG and PDF, and return the path of the PNG."""
    folder.mkdir(parents=True, exist_ok=True)
    varied = {axis: by_level for axis, by_level in found.items() if len(by_level) > 1}
    with print_style():
        paths = save(scaling_figure(varied or found, scenario), folder, "scaling")
    return next(path for path in paths if path.suffix == ".png")


def scaling_figure(found: Mapping[str, Levels], scenario: str) -> Figure:
    """Draw a panel for each axis, which all share the axis of steps."""
    figure = sheet(len(found) * (WIDTH + GAP), HEIGHT)
    grid = figure.add_gridspec(1, len(found), wspace=GAP / WIDTH, top=1.0, bottom=0.0)
    panels = grid.subplots(sharey=True, squeeze=False)[0]
    for axes, (label, by_level) in zip(panels, found.items(), strict=True):
        _panel(axes, label, by_level)
    first = panels[0]
    first.set(yscale="log", ylabel="mean steps")
    _step_ticks(first)
    first.legend(loc="best", fontsize=7, frameon=False)
    first.set_title(f"What more of it is worth on {plain(scenario)}", loc="left", pad=16)
    _note(first, _made_of([each for by_level in found.values() for each in by_level.values()]))
    return figure


def positions(levels: Sequence[float]) -> NDArray[np.float64]:
    """Return the places (K,) of levels on a logarithmic axis; an infinite one is a step beyond the largest."""
    finite = sorted(level for level in levels if math.isfinite(level)) or [1.0]
    step = finite[-1] / finite[-2] if len(finite) > 1 else 4.0
    return np.array([level if math.isfinite(level) else finite[-1] * step for level in levels])


def _panel(axes: Axes, label: str, by_level: Levels) -> None:
    order = sorted(by_level)
    x = positions(order)
    for metric, (colour, marker) in STYLES.items():
        means = [by_level[level].mean(metric) for level in order]
        axes.plot(x, [each.mean for each in means], color=colour, marker=marker, markersize=4, label=metric.upper())
        for place, each, level in zip(x, means, order, strict=True):
            if each.low is not None and each.high is not None:
                axes.plot([place, place], [each.low, each.high], color=colour, linewidth=1.2)
            dots = by_level[level].times[metric].mean(axis=1)
            axes.scatter(np.full(len(dots), place), dots, s=8, color=colour, alpha=0.5, linewidths=0)
    axes.set_xscale("log")
    axes.set_xticks(x, [_short(level) for level in order])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.margins(x=0.12)
    axes.set_xlabel(label)
    grid_below(axes)


def _short(level: float) -> str:
    """Return a level as a short label."""
    if math.isinf(level):
        return "no limit"
    for size, unit in ((1e6, " M"), (1e3, " k")):
        if level >= 10 * size or (level >= size and level % size == 0):
            return f"{level / size:.0f}{unit}"
    return f"{level:,.0f}"


def _step_ticks(axes: Axes) -> None:
    low, high = axes.get_ylim()
    axes.set_yticks([tick for tick in TICKS if low <= tick <= high])
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_locator(NullLocator())


def _made_of(found: Sequence[VariantScore]) -> str:
    seeds = span(len(variant.seeds) for variant in found)
    maps = found[0].times["t99"].shape[1]
    return f"Means over {seeds} trainings, a dot each, on {maps} unseen maps; 95 % intervals over both."


def _note(axes: Axes, text: str) -> None:
    axes.annotate(
        text, (0, 1), (0, 4), xycoords="axes fraction", textcoords="offset points", fontsize=7, color=GREY, va="bottom"
    )
