"""What the pictures of the documentation share: maps of cells with UAVs in them, and SVG files."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from indoor_explorers.evaluation.drawing.print_style import print_style

#: Colours of unknown, free, occupied, marked and lost cells.
COLOURS = ListedColormap(["#9aa0a6", "#f4f4f4", "#30343b", "#8fbce6", "#e0a458"])
MARKED, LOST = 3, 4
#: Cells of a side up to which the grid is drawn.
MOST_LINES = 24
UAV: dict[str, Any] = {"marker": "o", "color": "#d1495b", "markersize": 6, "linestyle": ""}


def svg(draw: Callable[[Figure], None]) -> bytes:
    """Return the SVG file of a figure that ``draw`` fills; equal figures give equal bytes."""
    with print_style():
        figure = Figure(layout="constrained")
        figure.set_facecolor("white")
        FigureCanvasSVG(figure)
        draw(figure)
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
