"""What the pictures of the site have in common."""

from __future__ import annotations

import io
from collections.abc import Callable

from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from indoor_explorers.evaluation.report.style.print_style import print_style


def svg(draw: Callable[[Figure], None]) -> bytes:
    """Return the SVG file of what ``draw`` paints on an empty white figure."""
    with print_style():
        figure = Figure(layout="constrained")
        figure.set_facecolor("white")
        FigureCanvasSVG(figure)
        draw(figure)
        file = io.BytesIO()
        figure.savefig(file, format="svg", metadata={"Date": None})
    return file.getvalue()
