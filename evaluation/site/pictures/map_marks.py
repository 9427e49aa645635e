"""Marks on the maps of pictures: paths, UAVs, goals, labels, coloured cells, and their legends."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import patheffects
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from indoor_explorers.env import OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.evaluation.drawing.palette import COLOURS as HUES
from indoor_explorers.evaluation.site.pictures.drawing import COLOURS, UAV

BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY = (on_white for on_white, _ in HUES[:6])
#: A white rim, so that lines are seen on every ground.
RIM = [patheffects.withStroke(linewidth=2.6, foreground="white")]


def line(axes: Any, points: Sequence[Any], **look: Any) -> None:
    """Draw a line through rows and columns."""
    axes.plot([col for _, col in points], [row for row, _ in points], **{"linewidth": 1.8, "path_effects": RIM} | look)


def uav_at(axes: Any, cell: Cell, **look: Any) -> None:
    """Draw a UAV in a cell."""
    axes.plot(cell[1], cell[0], **UAV | {"markeredgecolor": "white", "markeredgewidth": 0.8, "zorder": 5} | look)


def goal_at(axes: Any, cell: Cell, **look: Any) -> None:
    """Draw a goal in a cell."""
    style = {"marker": "*", "markersize": 11, "color": VERMILLION, "markeredgecolor": "white", "zorder": 6}
    axes.plot(cell[1], cell[0], **style | look)


def label_at(axes: Any, cell: tuple[float, float], text: str, **look: Any) -> None:
    """Write over a cell."""
    style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 7.5, "zorder": 7, "path_effects": RIM}
    axes.text(cell[1], cell[0], text, **style | look)


def tint(axes: Any, mask: NDArray[np.bool_], colour: str, alpha: float) -> None:
    """Colour the cells of a (H, W) mask."""
    shades = np.zeros((*mask.shape, 4))
    shades[mask] = to_rgba(colour, alpha)
    axes.imshow(shades, interpolation="nearest")


def legend(figure: Figure, handles: Sequence[Any], columns: int) -> None:
    """Draw a legend below all panels."""
    figure.legend(handles=handles, loc="outside lower center", ncols=columns, handlelength=1.8, columnspacing=1.4)


def mark(label: str, **look: Any) -> Line2D:
    """Return a marker for a legend."""
    return Line2D([], [], **{"linestyle": "", "color": "#444444"} | look, label=label)


def patch(code: np.integer[Any], label: str) -> Patch:
    """Return cells of a code for a legend."""
    colour: Any = COLOURS(int(code))
    return Patch(color=colour, label=label)


UAV_MARK = mark("UAV", **UAV)
GOAL_MARK = mark("goal", marker="*", markersize=9, color=VERMILLION)
UNKNOWN_PATCH, WALL_PATCH = patch(UNKNOWN, "unknown"), patch(OCCUPIED, "wall")
