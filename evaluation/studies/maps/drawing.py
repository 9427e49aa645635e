"""The figure of a comparison of maps: one panel for each statistic."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from indoor_explorers.env.files import writable
from indoor_explorers.env.maps.statistics import Statistic
from indoor_explorers.evaluation.drawing.palette import COLOURS, DASHES
from indoor_explorers.evaluation.drawing.print_style import plain, print_style, save_in_own_size, sheet
from indoor_explorers.evaluation.studies.maps.comparison import COMPARED, MapSet

#: Panels side by side.
COLUMNS = 3
#: Points of a curve: quantiles of the statistic.
POINTS = np.linspace(0.0, 1.0, 101)


def write_comparison(given: MapSet, others: Sequence[MapSet], folder: Path) -> list[Path]:
    """Draw the share of values below each value, for the given maps and the others, and return the figure's paths."""
    with writable(folder, "--figures"), print_style():
        folder.mkdir(parents=True, exist_ok=True)
        return save_in_own_size(comparison_figure(given, others), folder, "maps")


def comparison_figure(given: MapSet, others: Sequence[MapSet]) -> Figure:
    """Return a figure with a panel for each statistic."""
    rows = -(-len(COMPARED) // COLUMNS)
    figure = sheet(7.2, 1.75 * rows + 0.4)
    panels = figure.subplots(rows, COLUMNS, sharey=True).flat
    for kind, axes in zip(COMPARED, panels, strict=False):
        _panel(axes, kind, [given, *others])
    for axes in figure.axes[::COLUMNS]:
        axes.set_ylabel("share of values", fontsize=7.0)
    handles, names = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="lower center", ncols=5)
    figure.subplots_adjust(left=0.06, right=0.98, bottom=0.13, top=0.96, hspace=0.85, wspace=0.12)
    return figure


def _panel(axes: Axes, kind: Statistic, sets: Sequence[MapSet]) -> None:
    axes.set_title(kind.name)
    axes.set_xlabel(kind.unit, fontsize=7.0)
    if kind.logarithmic:
        axes.set_xscale("log")
        axes.xaxis.set_minor_formatter(NullFormatter())
    for number, one in enumerate(sets):
        if kind.name not in one.samples:
            continue
        values = one.samples[kind.name].quantiles(POINTS.tolist())
        colour, dash = ("#000000", ()) if number == 0 else (COLOURS[(number - 1) % len(COLOURS)][0], DASHES[number % 5])
        axes.step(
            np.exp(values) if kind.logarithmic else values,
            POINTS,
            where="post",
            color=colour,
            linewidth=1.8 if number == 0 else 1.2,
            linestyle=(0, tuple(0.5 * length for length in dash)) if dash else "-",
            label=plain(one.title),
        )
