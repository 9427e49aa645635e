"""The style of figures for print, and writing them as SVG, PNG and PDF: equal figures give equal bytes."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter
from matplotlib.transforms import Bbox, BboxBase

from indoor_explorers.env.files import written_whole
from indoor_explorers.evaluation.drawing.palette import DASHES, MARKERS, PolicyStyle

FORMATS: Mapping[str, dict[str, Any]] = {
    "svg": {"metadata": {"Date": None}},
    "png": {"metadata": {"Software": None}, "dpi": 200},
    "pdf": {"metadata": {"CreationDate": None}},
}
#: Inches around what is drawn.
PADDING = 0.08
#: Widths in inches of one and of two columns of a paper; a figure of this width is written exactly as wide.
COLUMN, PAGE = 3.5, 7.0
_LOOK: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "axes.labelsize": 8.5,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titlepad": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.edgecolor": "#444444",
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "legend.handlelength": 3.2,
    "svg.hashsalt": "indoor-explorers",
    "pdf.fonttype": 42,
}


@contextmanager
def print_style() -> Iterator[None]:
    """Draw in this style within a ``with`` block."""
    with mpl.rc_context(_LOOK):
        yield


def sheet(width: float, height: float, *, fitted: bool = False) -> Figure:
    """Return an empty figure of this size in inches; ``fitted`` makes room for labels and legend within it."""
    figure = Figure(figsize=(width, height), layout="constrained" if fitted else None)
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, folder: Path, stem: str) -> list[Path]:
    """Write a figure in every format and return the paths."""
    paths = [folder / f"{stem}.{ending}" for ending in FORMATS]
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        drawn = _extent(figure)  # measured once: each format would draw everything to measure
        for path, (ending, options) in zip(paths, FORMATS.items(), strict=True):
            with written_whole(path) as partial:
                figure.savefig(partial, format=ending, bbox_inches=drawn, **options)
    return paths


def save_in_own_size(figure: Figure, folder: Path, stem: str) -> list[Path]:
    """Write a figure as SVG and PNG in the size that it was made with, and return the paths."""
    paths = [folder / f"{stem}.{ending}" for ending in ("svg", "png")]
    for path in paths:
        with written_whole(path) as partial:
            figure.savefig(partial, format=path.suffix[1:], **FORMATS[path.suffix[1:]])
    return paths


def grid_below(axes: Axes, axis: Literal["both", "x", "y"] = "both", colour: str = "#e8e8e8") -> None:
    """Draw thin grid lines below the data."""
    axes.grid(axis=axis, color=colour, linewidth=0.6)
    axes.set_axisbelow(True)


def percent_axis(axis: Axis) -> None:
    """Label an axis of shares in percent."""
    axis.set_major_formatter(PercentFormatter(1.0, decimals=0, symbol=" %"))


def legend_beside(axes: Axes, right: float = 1.02) -> None:
    """Draw the legend to the right of the axes, ``right`` of their widths from their left edge."""
    axes.legend(loc="upper left", bbox_to_anchor=(right, 1.0), borderaxespad=0.0)


def _extent(figure: Figure) -> BboxBase:
    """Return what is written: all that is drawn, of a figure as wide as a column or two exactly this width."""
    if figure.get_layout_engine() is not None:
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # every format keeps this layout
        for legend in figure.legends:  # else it would move with the edge of what is written
            legend.set_bbox_to_anchor((0, 0, 1, 1), figure.transFigure)
    drawn, width = figure.get_tightbbox().padded(PADDING), figure.get_figwidth()
    return Bbox.from_extents(0, drawn.y0, width, drawn.y1) if width in (COLUMN, PAGE) else drawn


def plain(name: str, most: int = 40) -> str:
    """Return a name, shortened and escaped so that matplotlib does not parse it as math or hide it in legends."""
    name = name if len(name) <= most else name[: most - 1] + "…"
    return ("\u200a" if name.startswith("_") else "") + name.replace("\\", "\u29f5").replace("$", r"\$")


def strokes(style: PolicyStyle) -> dict[str, Any]:
    """Return the line and marker of a policy for matplotlib."""
    return {
        "color": style.hex,
        "linewidth": 1.4,
        "linestyle": (0, tuple(0.6 * length for length in DASHES[style.dash])) if DASHES[style.dash] else "-",
        "marker": MARKERS[style.marker][1],
        "markersize": 4.2,
        "markeredgewidth": 0.0,
    }
