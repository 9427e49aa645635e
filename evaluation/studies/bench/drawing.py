"""Figures of speed and decision time against map size, lidar range, team size and batch size."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Picture
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, NullFormatter, NullLocator

from indoor_explorers.env.files import writable
from indoor_explorers.evaluation.drawing.palette import COLOURS
from indoor_explorers.evaluation.drawing.print_style import print_style, save_in_own_size
from indoor_explorers.evaluation.studies.bench.deciding import SIDES, TEAM_SIDE, TEAMS
from indoor_explorers.evaluation.studies.bench.figure import Figure
from indoor_explorers.evaluation.studies.bench.growth import SERIES, GrowthSeries

#: Factor between the highest and lowest point and the frame.
ROOM = 2.5


def write_growth(measured: Iterable[Figure], folder: Path) -> list[Path]:
    """Draw the figures named ``growth-...`` into ``folder`` as SVG and PNG; return the paths."""
    values = {figure.name: figure.value for figure in measured}
    with writable(folder, "--figures"), print_style():
        folder.mkdir(parents=True, exist_ok=True)
        pictures = {"growth": growth_figure(values), "decisions": decisions_figure(values)}
        return [path for name, picture in pictures.items() for path in save_in_own_size(picture, folder, name)]


def growth_figure(values: dict[str, float]) -> Picture:
    """Draw four panels of agent-steps a second; ``values`` are by name, missing ones are left out."""
    picture = Picture(figsize=(7.2, 5.6), layout=ConstrainedLayoutEngine(hspace=0.06, wspace=0.03))
    FigureCanvasAgg(picture)
    picture.suptitle("Speed of the world while UAVs explore", x=0.01, ha="left", fontsize=10.5, fontweight="bold")
    panels = picture.subplots(2, 2, sharey=True).flat
    for place, (axes, series) in enumerate(zip(panels, SERIES, strict=True)):
        points = [(size, values.get(f"{series.name}-{series.label(size)}")) for size in series.sizes]
        _panel(axes, series, [(size, value) for size, value in points if value is not None], COLOURS[place][0])
    drawn = [value for series in SERIES for name, value in values.items() if name.startswith(series.name)]
    if drawn:
        picture.axes[0].set_ylim(min(drawn) / ROOM, max(drawn) * ROOM)
    for place in (0, 2):
        picture.axes[place].set_ylabel("agent-steps a second")
    return picture


def _panel(axes: Axes, series: GrowthSeries, points: list[tuple[int, float]], colour: str) -> None:
    """Draw one series with the value at each point."""
    _set_up(axes, series.quantity, series.rest, series.sizes, short)
    axes.set_axisbelow(True)
    if points:
        axes.plot(*zip(*points, strict=True), color=colour, marker="o", markersize=4.2, linewidth=1.4)
    halo = [withStroke(linewidth=2.5, foreground="white")]
    look: dict[str, Any] = {"ha": "center", "fontsize": 7, "color": "#444444", "path_effects": halo}
    for size, value in points:
        axes.annotate(short(value, 2), (size, value), (0, 7), textcoords="offset points", **look)


def _set_up(axes: Axes, quantity: str, rest: str, sizes: Sequence[int], text_of: Callable[[float], str]) -> None:
    """Give axes logarithmic scales, a tick for each size, and a title of what stays the same."""
    axes.set(xscale="log", yscale="log", xlabel=quantity)
    axes.set_title(rest, fontsize=8.5, fontweight="normal", color="#444444")
    axes.set_xticks(sizes, [f"{size}" for size in sizes])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: text_of(value)))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.grid(axis="y", color="#e3e3e3", linewidth=0.6)


def decisions_figure(values: dict[str, float]) -> Picture:
    """Draw the time of a decision that makes a plan against map size and team size; one line for each policy."""
    picture = Picture(figsize=(7.2, 4.2), layout=ConstrainedLayoutEngine(wspace=0.03))
    FigureCanvasAgg(picture)
    picture.suptitle("Decisions that make a plan, three quarters of the map known", x=0.01, ha="left", fontsize=10.5)
    panels = picture.subplots(1, 2, sharey=True).flat
    area = {side: f"growth-decide-area-{side}x{side}-" for side in SIDES}
    team = {size: f"growth-decide-team-{size}-" for size in TEAMS}
    _lines(next(panels), "side of the map in cells", "one UAV", area, values)
    _lines(next(panels), "UAVs in the team", f"map {TEAM_SIDE}x{TEAM_SIDE}, all linked", team, values)
    picture.axes[0].set_ylabel("median of a decision")
    handles, names = picture.axes[0].get_legend_handles_labels()
    picture.legend(handles, names, loc="outside lower center", ncols=5, fontsize=7, frameon=False)
    return picture


def _lines(axes: Axes, quantity: str, rest: str, starts: dict[int, str], values: dict[str, float]) -> None:
    """Draw one line for each policy; ``starts`` are the beginnings of the figures' names, by size."""
    _set_up(axes, quantity, rest, list(starts), human_time)
    policies = dict.fromkeys(
        name[len(start) :] for start in starts.values() for name in values if name.startswith(start)
    )
    for place, policy in enumerate(policies):
        points = [(size, values[start + policy]) for size, start in starts.items() if start + policy in values]
        colour, line = COLOURS[place % len(COLOURS)][0], ("-", "--", ":")[place // len(COLOURS) % 3]
        axes.plot(*zip(*points, strict=True), color=colour, linestyle=line, marker="o", markersize=3, label=policy)


def human_time(microseconds: float) -> str:
    """Format microseconds for an axis: 30 us, 4 ms."""
    return " ".join((short(microseconds / 1e3), "ms") if microseconds >= 1e3 else (short(microseconds), "us"))


def short(value: float, digits: int = 1) -> str:
    """Format a number for an axis: 250k, 1.3M."""
    for by, prefix in ((1e6, "M"), (1e3, "k")):
        if value >= by:
            return f"{float(f'{value / by:.{digits}g}'):g}{prefix}"
    return f"{float(f'{value:.{digits}g}'):g}"
