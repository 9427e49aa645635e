"""The figure of growth: speed against area, lidar range, team and batch, on logarithmic axes."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Picture
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, NullFormatter, NullLocator

from indoor_explorers.env import InputError
from indoor_explorers.env.files import written_whole
from indoor_explorers.evaluation.bench.figure import Figure
from indoor_explorers.evaluation.bench.growth import SERIES, Series
from indoor_explorers.evaluation.report.palette import COLOURS
from indoor_explorers.evaluation.report.paper import FORMATS, LOOK

#: Share of the value by which the highest and lowest point stay clear of the frame.
ROOM = 2.5


def write_growth(measured: Iterable[Figure], folder: Path) -> list[Path]:
    """Draw the figures named ``growth-...`` into ``folder`` as SVG and PNG; return the paths."""
    values = {figure.name: figure.value for figure in measured}
    paths = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with mpl.rc_context(LOOK):
            picture = growth_figure(values)
            for ending in ("svg", "png"):
                paths.append(folder / f"growth.{ending}")
                with written_whole(paths[-1]) as partial:
                    picture.savefig(partial, format=ending, **FORMATS[ending])
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror}; choose another --figures") from error
    return paths


def growth_figure(values: dict[str, float]) -> Picture:
    """Draw four panels of agent-steps a second; ``values`` are by the figures' names, missing ones are left out."""
    picture = Picture(figsize=(7.2, 5.6), layout=ConstrainedLayoutEngine(hspace=0.06, wspace=0.03))
    FigureCanvasAgg(picture)
    picture.suptitle("Speed of the world while UAVs explore", x=0.01, ha="left", fontsize=10.5, fontweight="bold")
    panels = picture.subplots(2, 2, sharey=True).flat
    for place, (axes, series) in enumerate(zip(panels, SERIES, strict=True)):
        points = [(size, values.get(f"{series.name}-{series.label(size)}")) for size in series.sizes]
        _panel(axes, series, [(size, value) for size, value in points if value is not None], COLOURS[place][0])
    drawn = [value for name, value in values.items() if name.startswith("growth-")]
    if drawn:
        picture.axes[0].set_ylim(min(drawn) / ROOM, max(drawn) * ROOM)
    for place in (0, 2):
        picture.axes[place].set_ylabel("agent-steps a second")
    return picture


def _panel(axes: Axes, series: Series, points: list[tuple[int, float]], colour: str) -> None:
    """Draw one series with the value at each point."""
    axes.set(xscale="log", yscale="log", xlabel=series.quantity)
    axes.set_title(series.rest, fontsize=8.5, fontweight="normal", color="#444444")
    axes.set_xticks(series.sizes, [f"{size}" for size in series.sizes])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: short(value)))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.grid(axis="y", color="#e3e3e3", linewidth=0.6)
    axes.set_axisbelow(True)
    if points:
        axes.plot(*zip(*points, strict=True), color=colour, marker="o", markersize=4.2, linewidth=1.4)
    halo = [withStroke(linewidth=2.5, foreground="white")]
    look: dict[str, Any] = {"ha": "center", "fontsize": 7, "color": "#444444", "path_effects": halo}
    for size, value in points:
        axes.annotate(short(value, 2), (size, value), (0, 7), textcoords="offset points", **look)


def short(value: float, digits: int = 1) -> str:
    """Return a number as an axis shows it: 250k, 1.3M."""
    for by, prefix in ((1e6, "M"), (1e3, "k")):
        if value >= by:
            return f"{float(f'{value / by:.{digits}g}'):g}{prefix}"
    return f"{float(f'{value:.{digits}g}'):g}"
