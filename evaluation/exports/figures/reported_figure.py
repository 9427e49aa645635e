"""The figure for print of a reported policy beside the flown ones: bars, those of reported policies hatched."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from indoor_explorers.evaluation.analysis.panels.reported_chart import ReportedChart
from indoor_explorers.evaluation.drawing.print_style import PAGE, plain
from indoor_explorers.evaluation.exports.figures.layout import add_note, paper


def reported_figure(chart: ReportedChart, title: str) -> Figure:
    """Draw a chart under the title of its scenario."""
    figure = paper(PAGE, 0.8 + 0.26 * len(chart.bars))
    axes = figure.add_subplot()
    for place, bar in enumerate(chart.bars):
        mean, low, high = bar.estimate
        look: dict[str, Any] = (
            {"facecolor": "white", "hatch": "//////"} if bar.reported else {"facecolor": bar.style.hex}
        )
        axes.barh([place], [mean], height=0.66, edgecolor=bar.style.hex, linewidth=0.9, **look)
        if low is not None and high is not None:
            axes.hlines([place], low, high, color="#222222", linewidth=1.2)
    axes.set(ylim=(len(chart.bars) - 0.4, -0.6), xlim=(0, 1.05 * chart.most), xlabel=f"{chart.title}, {chart.over}")
    axes.set_yticks(range(len(chart.bars)), [plain(bar.name) for bar in chart.bars])
    axes.tick_params(axis="y", length=0)
    axes.set_title(plain(title, 70))
    add_note(figure, f"Means with 95 % bootstrap intervals. Hatched: {plain(chart.note, 400)}")
    return figure
