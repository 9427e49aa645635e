"""Overlays of a map: UAVs, last received positions, trails, links, ranges. Places are in cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.rendering.layout import Box
from indoor_explorers.env.rendering.level_grid import LevelGrid
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
    grid: LevelGrid
    """Where the cells are on the map's pixels."""

    @property
    def radius(self) -> float:
        """Of a UAV's disc in pixels."""
        return max(0.38 * self.cell, self.least)

    def centre(self, cell: Cells) -> tuple[float, float]:
        """Return (x, y) of the middle of a cell on ``inside``."""
        row, col = self.grid.places(np.asarray(cell)).tolist()
        return (col + 0.5) * self.cell, (row + 0.5) * self.cell

    def middles(self, cells: Cells) -> NDArray[np.float64]:
        """Return (x, y) of the middles of cells (..., 2) on ``inside``, in cells."""
        return np.asarray(self.grid.places(cells)[..., ::-1] + 0.5)

    def level_of(self, cells: Cells) -> Cells:
        """Return the levels (...) of cells (..., 2)."""
        return np.asarray(self.grid.levels.voxels(np.asarray(cells))[..., 0])

    def tile(self, level: int) -> Box:
        """Return the pixels of a level on ``inside``; all where there is one level."""
        if self.grid.levels.number == 1:
            return Box(0, 0, self.inside.shape[0], self.inside.shape[1])
        (row, col), (_, height, width) = self.grid.corner(level), self.grid.levels
        top, left = round(row * self.cell), round(col * self.cell)
        return Box(top, left, round((row + height) * self.cell) - top, round((col + width) * self.cell) - left)

    def on_level(self, cell: Cells) -> tuple[Canvas, tuple[float, float]]:
        """Return the pixels of a cell's level, and (x, y) of the middle of the cell on them."""
        (top, left, height, width), (x, y) = self.tile(int(self.level_of(cell))), self.centre(cell)
        return self.inside[top : top + height, left : left + width], (x - left, y - top)

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
    others = np.abs(chart.middles(np.delete(cells, agent, axis=0)) * chart.cell + OVERHANG - (x, y + away))
    hidden = bool((others < (half + chart.radius, 8 + chart.radius)).all(axis=1).any())
    y += -away if (hidden and y > away + 10) or y + away > height - 10 else away
    stroke(chart.around, [(x - half + 8, y), (x + half - 8, y)], PAGE, 16, 0.92)
    write(chart.around, (x, y), text, 12, INK)


def trail(chart: Chart, cells: Cells, colour: Colour, lane: float) -> None:
    """Draw a UAV's past (K, 2) cells, older ones thinner and fainter; ``lane`` shifts the line by a share of a cell.

    It is broken where the UAV left a level.
    """
    moved = np.flatnonzero((cells[1:] != cells[:-1]).any(axis=1))
    if not len(moved):
        return
    places = np.concatenate((cells[moved], cells[moved[-1] + 1][None]))
    age = (len(cells) - 2 - moved) / max(len(cells) - 1, 40)
    width = min(max(0.16 * chart.cell, 2.0), 6.0) * (1 - 0.55 * age)
    alpha = np.where(np.diff(chart.level_of(places)), 0.0, 0.08 + 0.82 * (1 - age) ** 1.5)
    stroke(chart.inside, (chart.middles(places) + lane) * chart.cell, colour, width, alpha)
    changes(chart, places, colour)


def changes(chart: Chart, cells: Cells, colour: Colour) -> None:
    """Mark where a way of cells (K, 2) leaves a level: by an angle that points up or down."""
    rises, size = np.diff(chart.level_of(cells)), max(0.25 * chart.cell, 4.0)
    for place in np.flatnonzero(rises).tolist():
        (x, y), up = chart.centre(cells[place]), size * np.sign(rises[place])
        angle = [(x - size, y + up / 2), (x, y - up / 2), (x + size, y + up / 2)]
        for width, ink in ((4.5, np.array(PAGE, np.uint8)), (2.2, colour)):
            stroke(chart.inside, angle, ink, width, 0.95)


def links(chart: Chart, cells: Cells, linked: NDArray[np.bool_]) -> None:
    """Draw a line between ``cells`` (M, 2) in radio contact, ``linked`` (M, M); many lines are fainter.

    Those between levels are dashed.
    """
    pairs = np.argwhere(np.triu(linked, 1))
    strength = 1.0 / max(1.0, len(pairs) / max(4.0 * len(cells), 24.0)) ** 0.5
    lines = [[chart.centre(cells[one]) for one in pair] for pair in pairs.tolist()]
    apart = np.diff(chart.level_of(cells[pairs]), axis=1)[:, 0] != 0
    for line in lines:
        stroke(chart.inside, line, PAGE, 4.2, 0.75 * strength)
    for line, broken in zip(lines, apart.tolist(), strict=True):
        parts = _dashed(*line) if broken else line
        stroke(chart.inside, parts, INK, 1.7, np.where(np.arange(len(parts) - 1) % 2, 0.0, 0.85 * strength))


def _dashed(start: tuple[float, float], end: tuple[float, float]) -> NDArray[np.float64]:
    """Return the points between which a dashed line is drawn, and is not, in turn."""
    count = max(int(np.hypot(end[0] - start[0], end[1] - start[1]) / 7), 1)
    return np.linspace(start, end, count + 1)


def lidar_reach(chart: Chart, cell: Cells, reach: float, colour: Colour) -> None:
    """Outline the range of a lidar, ``reach`` in cells."""
    canvas, place = chart.on_level(cell)
    ring(canvas, place, reach * chart.cell, colour, 1.4, 0.7)


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
    canvas, place = chart.on_level(cell)
    stroke(canvas, outline + place, colour, 1.0, dashes)


def _number(canvas: Canvas, place: tuple[float, float], radius: float, colour: Colour, agent: int) -> None:
    size = radius * (1.35, 1.35, 1.2, 0.85)[len(str(agent))]
    if size >= 7:
        write(canvas, place, str(agent), size, colour)
