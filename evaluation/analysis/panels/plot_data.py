"""The data of a plot, which the page and the figures for print draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from indoor_explorers.evaluation.drawing.palette import PolicyStyle
from indoor_explorers.evaluation.statistics import Estimate


@dataclass(frozen=True, kw_only=True)
class PlotAxis:
    """One axis."""

    title: str
    low: float
    high: float
    log: bool = False
    share: bool = False
    """Whether its numbers are shown as percent."""
    ticks: tuple[tuple[float, str], ...] = ()
    """Labelled places; empty for automatic ones."""


@dataclass(frozen=True, kw_only=True)
class PlotSeries:
    """The points of one policy."""

    name: str
    style: PolicyStyle
    x: list[float]
    y: list[float]
    text: list[str]
    """Text of each point, shown under the pointer."""
    low: list[float] | None = None
    """Lower ends of the intervals of ``y``; None: no interval."""
    high: list[float] | None = None
    right: list[float] | None = None
    """Right ends of whiskers along x."""
    dots: list[tuple[float, float]] | None = None
    """Single episodes, drawn small."""
    hollow: list[bool] | None = None
    """Points to be drawn hollow."""
    line: bool = True
    step: bool = False
    """Whether the line is a step function."""

    def data(self) -> dict[str, Any]:
        """Return JSON data; what is not set is left out."""
        about = {key: value for key, value in asdict(self).items() if value is not None and key != "style"}
        rounded = {key: _rounded(value) if isinstance(value, list) else value for key, value in about.items()}
        return {**rounded, **self.style._asdict(), "pattern": self.style.pattern}


@dataclass(frozen=True, kw_only=True)
class Guide:
    """A reference line."""

    name: str
    x: list[float]
    y: list[float]
    step: bool = False


@dataclass(frozen=True, kw_only=True)
class Plot:
    """A plot with its title; the caption is the panel's."""

    title: str
    label: str
    """Alternative text."""
    x: PlotAxis
    y: PlotAxis
    series: Sequence[PlotSeries]
    guides: Sequence[Guide] = ()
    beyond: str = ""
    """A sentence about the policies that the range leaves out; empty where it has all."""

    def data(self) -> dict[str, Any]:
        """Return JSON data for the page."""
        return {
            "x": asdict(self.x),
            "y": asdict(self.y),
            "series": [each.data() for each in self.series],
            "guides": [asdict(each) for each in self.guides],
            "beyond": self.beyond,
        }


def _rounded(values: list[Any]) -> list[Any]:
    """Round to five significant digits, more than a screen shows."""
    return [float(f"{value:.5g}") if isinstance(value, float) else value for value in values]


def bounds(estimates: Sequence[Estimate]) -> tuple[list[float] | None, list[float] | None]:
    """Return lower and upper ends of intervals, the means where one is missing; None when all are missing."""
    if all(each.low is None for each in estimates):
        return None, None
    lows = [each.mean if each.low is None else each.low for each in estimates]
    highs = [each.mean if each.high is None else each.high for each in estimates]
    return lows, highs
