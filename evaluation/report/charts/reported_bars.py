"""Bars of flown and reported policies as inline SVG; those of reported policies are hatched."""

from __future__ import annotations

from markupsafe import Markup

from indoor_explorers.evaluation.analysis.panels.reported_chart import Bar, ReportedChart
from indoor_explorers.evaluation.drawing.formatting import with_interval

#: Width of the drawing, where its bars begin and end, and the height of a row, in pixels.
WIDTH, LEFT, RIGHT, ROW = 640, 180, 470, 22
#: Characters of a name that are shown.
LONGEST = 26


def reported_bars(chart: ReportedChart, key: str) -> Markup:
    """Draw a chart; ``key`` is what its parts are named by, unlike those of every other chart of the page."""
    rows = Markup("").join(_row(bar, row, chart, f"{key}-{row}") for row, bar in enumerate(chart.bars))
    return Markup(
        '<svg class="reported-bars" viewBox="0 0 {w} {h}" role="img" aria-label="{label}">{rows}</svg>'
    ).format(w=WIDTH, h=ROW * len(chart.bars) + 4, label=f"{chart.title}, means {chart.over}", rows=rows)


def _row(bar: Bar, row: int, chart: ReportedChart, key: str) -> Markup:
    def place(value: float) -> float:
        return round(LEFT + (RIGHT - LEFT) * min(max(value / chart.most, 0.0), 1.0), 1)

    top, end = row * ROW + 4, place(bar.estimate.mean)
    hatch = Markup(
        '<pattern id="{}" width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">'
        '<path d="M1 0V6" stroke="currentColor" stroke-width="1.6"/></pattern>'
    ).format(key)
    whisker = Markup("")
    if bar.estimate.low is not None and bar.estimate.high is not None:
        ends = (place(bar.estimate.low), top + 7, place(bar.estimate.high))
        whisker = Markup('<path class="whisker" d="M{} {}H{}"/>').format(*ends)
    name = bar.name if len(bar.name) <= LONGEST else f"{bar.name[: LONGEST - 3]}…{bar.name[-2:]}"
    return Markup(
        '<g style="color:{}">{}<rect{} x="{}" y="{}" width="{}" height="14" fill="{}" stroke="currentColor"/>{}</g>'
        '<text x="{}" y="{y}" text-anchor="end">{}</text><text x="{}" y="{y}">{}</text>'
    ).format(
        *(bar.style.variable, hatch if bar.reported else "", Markup(' class="hatched"') if bar.reported else ""),
        *(LEFT, top, round(end - LEFT, 1), f"url(#{key})" if bar.reported else "currentColor", whisker),
        *(LEFT - 8, name, RIGHT + 8, with_interval(bar.estimate, chart.decimals)),
        y=top + 11,
    )
