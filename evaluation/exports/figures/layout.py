"""Sheets for a paper: as wide as one column or two, with the legend and a note below what is drawn."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from indoor_explorers.evaluation.drawing.palette import Styles
from indoor_explorers.evaluation.drawing.print_style import PAGE, plain, sheet, strokes

#: Inches of a letter of the legend and of the note, of a legend's line with its gaps, and of a row of the legend.
LETTER, SMALL, HANDLE, ROW = 0.061, 0.051, 0.58, 0.165


def paper(width: float, height: float, legend: Sequence[str] = ()) -> Figure:
    """Return an empty figure for a drawing of this height in inches, and room for the legend of these labels."""
    return sheet(width, height + ROW * -(-len(legend) // _columns(width, legend)), fitted=True)


def _columns(width: float, labels: Sequence[str]) -> int:
    """Return how many labels fit side by side."""
    longest = max(map(len, labels), default=1)
    return max(1, min(len(labels) or 1, int(width / (HANDLE + LETTER * longest))))


def add_legend(figure: Figure, names: Sequence[str], styles: Styles, labels: Sequence[str] = ()) -> None:
    """Write the legend below the axes, in the order of the styles, which is that of the experiment."""
    shown = dict(zip(names, labels or [plain(name) for name in names], strict=True))
    ordered = [name for name in styles if name in shown]
    figure.legend(
        [Line2D([], [], **strokes(styles[name])) for name in ordered],
        [shown[name] for name in ordered],
        loc="outside lower left",
        ncols=_columns(figure.get_figwidth(), list(shown.values())),
        columnspacing=1.2,
    )


def add_note(figure: Figure, text: str) -> None:
    """Write a note below the figure that says what it shows."""
    width, height = figure.get_size_inches()
    lines = textwrap.wrap(" ".join(text.split()), int((width - 0.1) / SMALL))
    look: dict[str, Any] = {"fontsize": 7 if width == PAGE else 6.5, "color": "#666666", "va": "top"}
    figure.text(0.05 / width, -0.06 / height, "\n".join(lines), **look)
