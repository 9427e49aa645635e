"""Helpers of the documentation's pictures: flights, maps of cells with UAVs in them, and SVG files."""

from __future__ import annotations

import io
from collections.abc import Callable
from itertools import islice
from typing import Any

import numpy as np
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from indoor_explorers.env import OCCUPIED, Pilot, Policy, World
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.simulation.rollout import Uav, ask_pilots, make_pilots, rollout
from indoor_explorers.evaluation.drawing.print_style import print_style

#: Colours of unknown, free, occupied, marked and lost cells.
COLOURS = ListedColormap(["#9aa0a6", "#f4f4f4", "#30343b", "#8fbce6", "#e0a458"])
MARKED, LOST = 3, 4
#: Cells of a side up to which the grid is drawn.
MOST_LINES = 24
UAV: dict[str, Any] = {"marker": "o", "color": "#d1495b", "markersize": 6, "linestyle": ""}
#: The box behind a text on a map.
PLATE = {"facecolor": "white", "alpha": 0.85, "edgecolor": "none", "boxstyle": "round,pad=0.15"}


def fly_steps(world: World, policy: Policy, steps: int) -> dict[Uav, Pilot]:
    """Fly a begun episode for at most this many steps, and return the pilots."""
    pilots = make_pilots(policy, world)
    for _ in islice(rollout(world, ask_pilots(policy, pilots, world)), steps):
        pass
    return pilots


def svg(draw: Callable[[Figure], None]) -> bytes:
    """Return the SVG file of a figure that ``draw`` fills; equal figures give equal bytes."""
    with print_style():
        figure = Figure(layout="constrained")
        figure.set_facecolor("white")
        FigureCanvasSVG(figure)
        draw(figure)
        return svg_of(figure)


def svg_of(figure: Figure) -> bytes:
    """Return the SVG file of a figure that was drawn in the style for print; equal figures give equal bytes."""
    file = io.BytesIO()
    figure.savefig(file, format="svg", metadata={"Date": None}, bbox_inches="tight", pad_inches=0.04)
    return file.getvalue()


def cells(axes: Any, codes: NDArray[Any], title: str, uavs: Any = ()) -> None:
    """Draw (H, W) codes of :data:`COLOURS` as a grid, with UAVs in some cells."""
    axes.imshow(codes, cmap=COLOURS, vmin=0, vmax=LOST, interpolation="nearest")
    for row, col in uavs:
        axes.plot(col, row, **UAV)
    if max(codes.shape) <= MOST_LINES:
        axes.hlines(np.arange(len(codes) + 1) - 0.5, -0.5, codes.shape[1] - 0.5, color="#c8ccd1", linewidth=0.4)
        axes.vlines(np.arange(codes.shape[1] + 1) - 0.5, -0.5, len(codes) - 0.5, color="#c8ccd1", linewidth=0.4)
    axes.set_axis_off()
    axes.set_title(title)


def plan_map(axes: Any, plan: Floorplan, wall: str) -> None:
    """Draw the walls of a floor in metres from its upper left corner."""
    height, width = (cells * (plan.resolution or 1.0) for cells in plan.truth.shape)
    shown = ListedColormap(["#ffffff", wall])
    axes.imshow(plan.truth == OCCUPIED, cmap=shown, extent=(0, width, height, 0), interpolation="nearest")
