"""Lines of greedy evaluations, and legends, in the pictures of the thesis's learner."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from indoor_explorers.evaluation.drawing.formatting import fixed
from indoor_explorers.evaluation.drawing.palette import COLOURS
from indoor_explorers.evaluation.drawing.print_style import percent_axis
from indoor_explorers.evaluation.site.studies.thesis import MeasuredTraining

LABELS = ("as it was", "mended")
#: Lines of the first and of the second seed.
SEEDS: dict[int, Any] = {1: "-", 2: (0, (3, 1.5))}
#: The figures of greedy evaluations: labels and colours.
GREEDY = {
    "coverage": ("coverage", COLOURS[2][0]),
    "reached": ("90 % reached", COLOURS[3][0]),
    "crashed": ("UAVs crashed", COLOURS[6][0]),
    "stuck": ("UAVs stuck", COLOURS[4][0]),
}

Pair = tuple[MeasuredTraining, ...]


class Curve(NamedTuple):
    """The trainings that a line of a plot is about."""

    pair: Pair
    label: str = ""
    colour: str | None = None
    """None: that of the version."""


def draw_greedy(axes: Axes, figures: Callable[[str], NDArray[np.float64]], seed: int) -> None:
    """Draw the figures of a training's greedy evaluations, by the number of training episodes before them."""
    episodes = figures("episodes")
    for name, (_, colour) in GREEDY.items():
        axes.plot(episodes, figures(name), color=colour, linestyle=SEEDS[seed], linewidth=1.2)
    axes.set(xlim=(0, episodes[-1]), ylim=(-0.03, 1.03), xlabel="training episode", ylabel="share")
    axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: fixed(value, 0)))
    percent_axis(axes.yaxis)


def curve_legend(curves: Sequence[Curve] = (), *, greedy: bool = False, seeds: bool = False) -> list[Line2D]:
    """Return the lines of a legend: curves, each label once; figures of greedy evaluations; and seeds."""
    looks: dict[str, dict[str, Any]] = {curve.label: {"color": curve.colour} for curve in curves}
    if greedy:
        looks |= {label: {"color": colour} for label, colour in GREEDY.values()}
    if seeds:
        looks |= {f"seed {seed}": {"color": "#222222", "linestyle": dash} for seed, dash in SEEDS.items()}
    return [Line2D([], [], label=label, **look) for label, look in looks.items()]
