"""The figures of a search: its trials in order, and the importance of the parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from indoor_explorers.evaluation.drawing.palette import COLOURS
from indoor_explorers.evaluation.drawing.print_style import (
    grid_below,
    legend_beside,
    percent_axis,
    plain,
    print_style,
    save,
    sheet,
)
from indoor_explorers.evaluation.studies.tuning.trials import Flown

GREY = "#777777"
#: Values farther from the default's than this many times the range of the trials flown to the end are drawn at the rim.
RIM = 2.0


def write_figures(flown: Sequence[Flown], importances: Mapping[str, float], title: str, folder: Path) -> None:
    """Write the history, and the importances if there are any, each as SVG, PNG and PDF."""
    folder.mkdir(parents=True, exist_ok=True)
    with print_style():
        save(history_figure(flown, title), folder, "history")
        if importances:
            save(importance_figure(importances), folder, "importance")


def history_figure(flown: Sequence[Flown], title: str) -> Figure:
    """Draw the value of each trial, those dropped as estimated, and the best value so far."""
    figure = sheet(7.6, 3.0)
    axes: Axes = figure.subplots()
    kept, dropped = ([each for each in flown if each.dropped is which] for which in (False, True))
    axes.axhline(1.0, color=GREY, linewidth=0.8, linestyle=(0, (4, 3)), label="default")
    steps = [each.best for each in flown]
    axes.step([each.number for each in flown], steps, where="post", color=COLOURS[0][0], linewidth=1.4, label="best")
    dots: dict[str, Any] = {"linestyle": "", "markersize": 4.5}
    axes.plot([each.number for each in kept], [each.value for each in kept], marker="o", color=COLOURS[0][0], **dots)
    axes.lines[-1].set_label("all episodes")
    if dropped:
        axes.plot([each.number for each in dropped], [each.value for each in dropped], marker="x", color=GREY, **dots)
        axes.lines[-1].set_label("dropped, as estimated")
    _limit(axes, [each.value for each in kept], [each.value for each in dropped])
    axes.set(xlabel="trial", ylabel=f"{title} / default's")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    grid_below(axes)
    legend_beside(axes)
    return figure


def _limit(axes: Axes, kept: Sequence[float], dropped: Sequence[float]) -> None:
    """Cut off trials far worse than those flown to the end, which would hide the differences of the others."""
    spread = max(float(np.ptp(kept)), 0.05)
    low, high = min(kept) - RIM * spread, max(kept) + RIM * spread
    if dropped and not low <= min(dropped) <= max(dropped) <= high:
        axes.set_ylim(max(low, min(*dropped, *kept) - 0.1 * spread), min(high, max(*dropped, *kept) + 0.1 * spread))


def importance_figure(importances: Mapping[str, float]) -> Figure:
    """Draw a bar for each parameter, the most important on top."""
    figure = sheet(8.4, 0.4 + 0.18 * len(importances))
    axes: Axes = figure.subplots()
    axes.barh(range(len(importances)), list(importances.values()), height=0.62, color=COLOURS[0][0])
    axes.set_yticks(range(len(importances)), [plain(name) for name in importances])
    axes.invert_yaxis()
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel("importance")
    percent_axis(axes.xaxis)
    grid_below(axes, "x")
    return figure
