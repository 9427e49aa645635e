"""Overlays of a map: UAVs, last received positions, trails, links, ranges. Places are in cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.rendering.palette import INK, PAGE, STOP, ink_on
from indoor_explorers.env.rendering.primitives import Canvas, disc, ring, stroke, text_width, write

#: Pixels that a UAV's disc may reach beyond its map.
OVERHANG = 10
#: Age in steps over which the mark of a teammate fades, and its opacity then.
MATE_FADES, MATE_STAYS = 80, 0.45

Colour = NDArray[np.uint8]
Cells = NDArray[np.int64]


@dataclass(frozen=True)
class Chart:
    """A map on the canvas that overlays are drawn on."""

    inside: Canvas
    """The map's own pixels: trails, links and reach end at its border."""
    around: Canvas
    """The map with ``OVERHANG`` more pixels on each side for discs and labels."""
    cell: float
    """Pixels of a cell."""
    least: float
    """Least radius of a UAV in pixels."""

    @property
    def radius(self) -> float:
        """Of a UAV's disc in pixels."""
        return max(0.38 * self.cell, self.least)

    def centre(self, cell: Cells) -> tuple[float, float]:
        """Return (x, y) of the middle of a cell on ``inside``."""
        return (float(cell[1]) + 0.5) * self.cell, (float(cell[0]) + 0.5) * self.cell

    def outer(self, cell: Cells) -> tuple[float, float]:
        """Return (x, y) of the middle of a cell on ``around``."""
        x, y = self.centre(cell)
        return x + OVERHANG, y + OVERHANG


def uav(chart: Chart, cell: Cells, colour: Colour, agent: int) -> None:
    """Draw a disc with the UAV's number."""
    place = chart.outer(cell)
    disc(chart.around, place, chart.radius + 1.5, PAGE, 0.95)
    disc(chart.around, place, chart.radius, colour)
    _number(chart.around, place, chart.radius, np.array(ink_on(colour), np.uint8), agent)


def stopped(chart: Chart, cell: Cells) -> None:
    """Cross out a UAV that a failure has stopped."""
    (x, y), arm = chart.outer(cell), 1.15 * chart.radius
    for width, colour in ((5.5, PAGE), (2.5, STOP)):
        for slope in (-1, 1):
            stroke(chart.around, [(x - arm, y - slope * arm), (x + arm, y + slope * arm)], colour, width)


def base(chart: Chart, cell: Cells) -> None:
    """Mark the home base as a landing pad: an H in a ring."""
    place, radius = chart.outer(cell), max(1.3 * chart.radius, 8.0)
    disc(chart.around, place, radius, PAGE, 0.95)
    ring(chart.around, place, radius - 1.0, INK, 2.0)
    write(chart.around, place, "H", round(1.3 * radius), INK)


def mate(chart: Chart, cell: Cells, colour: Colour, agent: int, age: int, *, small: bool) -> None:
    """Mark the last received cell of a teammate: a hollow disc that fades with age."""
    place, radius = chart.outer(cell), chart.radius * (0.6 if small else 1.0)
    strength = max(MATE_STAYS, 1.0 - age / MATE_FADES)
    disc(chart.around, place, radius, PAGE, 0.9)
    ring(chart.around, place, radius - 0.8, colour, 1.6, strength)
    _number(chart.around, place, radius, np.asarray(255 - strength * (255.0 - colour), np.uint8), agent)


def label(chart: Chart, cells: Cells, agent: int, text: str) -> None:
    """Write ``text`` below a UAV, or above it if another one of ``cells`` (N, 2) or the border is in the way."""
    x, y = chart.outer(cells[agent])
    height, width = chart.around.shape[:2]
    half, away = text_width(text, 12) / 2 + 6, chart.radius + 12
    x = min(max(x, half + 2), width - half - 2)
    others = np.abs((np.delete(cells, agent, axis=0)[:, ::-1] + 0.5) * chart.cell + OVERHANG - (x, y + away))
    hidden = bool((others < (half + chart.radius, 8 + chart.radius)).all(axis=1).any())
    y += -away if (hidden and y > away + 10) or y + away > height - 10 else away
    stroke(chart.around, [(x - half + 8, y), (x + half - 8, y)], PAGE, 16, 0.92)
    write(chart.around, (x, y), text, 12, INK)


def trail(chart: Chart, cells: Cells, colour: Colour, lane: float) -> None:
    """Draw a UAV's past (K, 2) cells, older ones thinner and fainter; ``lane`` shifts the line by a share of a cell."""
    moved = np.flatnonzero((cells[1:] != cells[:-1]).any(axis=1))
    if not len(moved):
        return
    places = np.concatenate((cells[moved], cells[moved[-1] + 1][None]))
    age = (len(cells) - 2 - moved) / max(len(cells) - 1, 40)
    width = min(max(0.16 * chart.cell, 2.0), 6.0) * (1 - 0.55 * age)
    stroke(chart.inside, (places[:, ::-1] + 0.5 + lane) * chart.cell, colour, width, 0.08 + 0.82 * (1 - age) ** 1.5)


def links(chart: Chart, cells: Cells, linked: NDArray[np.bool_]) -> None:
    """Draw a line between ``cells`` (M, 2) in radio contact, ``linked`` (M, M); many lines are fainter."""
    pairs = np.argwhere(np.triu(linked, 1))
    strength = 1.0 / max(1.0, len(pairs) / max(4.0 * len(cells), 24.0)) ** 0.5
    lines = [[chart.centre(cells[one]) for one in pair] for pair in pairs.tolist()]
    for line in lines:
        stroke(chart.inside, line, PAGE, 4.2, 0.75 * strength)
    for line in lines:
        stroke(chart.inside, line, INK, 1.7, 0.85 * strength)


def lidar_reach(chart: Chart, cell: Cells, reach: float, colour: Colour) -> None:
    """Outline the range of a lidar, ``reach`` in cells."""
    ring(chart.inside, chart.centre(cell), reach * chart.cell, colour, 1.4, 0.7)


def radio_reach(chart: Chart, cell: Cells, model: str, reach: float, colour: Colour) -> None:
    """Outline, dashed, a radio's range in open space; ``none`` and ``unlimited`` have no outline."""
    if model == "square":
        side = (reach + 0.5) * chart.cell
        corners = np.array([(-side, -side), (side, -side), (side, side), (-side, side), (-side, -side)])
        along = np.linspace(0, 4, 4 * max(int(2 * side / 5), 1) + 1)
        outline = np.stack([np.interp(along, np.arange(5), corners[:, k]) for k in (0, 1)], axis=1)
    elif model not in {"none", "unlimited"} and reach > 0:
        angle = np.linspace(0, 2 * np.pi, max(int(2 * np.pi * reach * chart.cell / 5), 8))
        outline = reach * chart.cell * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    else:
        return
    dashes = np.where(np.arange(len(outline) - 1) % 2, 0.0, 0.6)
    stroke(chart.inside, outline + chart.centre(cell), colour, 1.0, dashes)


def _number(canvas: Canvas, place: tuple[float, float], radius: float, colour: Colour, agent: int) -> None:
    size = radius * (1.35, 1.35, 1.2, 0.85)[len(str(agent))]
    if size >= 7:
        write(canvas, place, str(agent), size, colour)
