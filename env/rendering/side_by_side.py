"""Paint the flights of several policies side by side: each team's map with a chart of its coverage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.rendering.layout import GAP, MARGIN, Box, cell_size
from indoor_explorers.env.rendering.painter import floored_percent, paint_team_map
from indoor_explorers.env.rendering.palette import BAR, FAINT, HAIRLINE, INK, TROUGH
from indoor_explorers.env.rendering.primitives import Canvas, disc, fitting, stroke, text_width, write
from indoor_explorers.env.rendering.scene import Scene
from indoor_explorers.env.search.connected_parts import extent

#: The most flights in a picture.
MOST = 6
#: Pixels of the longer side of a map, of the title above it, and of the chart and the numbers below it.
SIDE, TITLE, CHART, NUMBERS = 288, 26, 48, 18
#: Levels of coverage that the charts mark.
LEVELS = (0.5, 0.9)


class SideBySide(NamedTuple):
    """One policy's flight at one step."""

    name: str
    """Of the policy."""
    scene: Scene
    coverage: Sequence[float]
    """Of the team, at the start and after each step."""


def paint_side_by_side(flights: Sequence[SideBySide], longest: int) -> NDArray[np.uint8]:
    """Return a picture (h, w, 3) uint8 of flights over maps of one size; the charts end at step ``longest``."""
    flights = [flight._replace(scene=_cropped(flight.scene)) for flight in flights]
    tall, wide = flights[0].scene.grid.shape
    cell = cell_size(SIDE / max(tall, wide))
    height, width = max(1, round(tall * cell)), max(1, round(wide * cell))
    columns = _columns(len(flights), height, width)
    rows = -(-len(flights) // columns)
    down, across = TITLE + height + GAP + CHART + NUMBERS, width + GAP
    size = 2 * MARGIN + rows * down + (rows - 1) * GAP, 2 * MARGIN + columns * across - GAP
    canvas = np.full((*size, 3), 255, np.uint8)
    for k, flight in enumerate(flights):
        top, left = MARGIN + (k // columns) * (down + GAP), MARGIN + (k % columns) * across
        _title(canvas, top, left, width, flight)
        paint_team_map(canvas, Box(top + TITLE, left, height, width), flight.scene)
        _chart(canvas, Box(top + TITLE + height + GAP, left, CHART, width), flight, max(longest, 1))
    return canvas


def _cropped(scene: Scene) -> Scene:
    """Return a scene without the solid cells around its free cells; one of several levels as it is."""
    if scene.level_count > 1:
        return scene
    rows, cols = extent(scene.truth == FREE)
    top, left = max(0, rows.start - 1), max(0, cols.start - 1)
    window = np.s_[..., top : rows.stop + 1, left : cols.stop + 1]
    return replace(
        scene,
        truth=scene.truth[window],
        union=scene.union[window],
        beliefs=scene.beliefs[window],
        in_view=scene.in_view[window],
        trails=scene.trails - (top, left),
        heard_cell=scene.heard_cell - (top, left),
        prior=None if scene.prior is None else scene.prior[window],
        base=None if scene.base is None else (scene.base[0] - top, scene.base[1] - left),
    )


def _columns(count: int, height: int, width: int) -> int:
    """Return the number of columns for which the picture's aspect ratio is nearest to 3:2."""

    def lopsided(columns: int) -> float:
        rows = -(-count // columns)
        return abs(float(np.log(columns * width / (rows * (height + CHART + TITLE)) / 1.5))) + (columns * rows - count)

    return min(range(1, count + 1), key=lopsided)


def _title(canvas: Canvas, top: int, left: int, width: int, flight: SideBySide) -> None:
    facts = floored_percent(flight.coverage[-1])
    line = top + TITLE / 2 - 2
    write(canvas, (left + width, line), facts, 15, INK, anchor=1.0)
    write(canvas, (left, line), fitting(flight.name, 15, width - text_width(facts, 15) - 10), 15, INK, anchor=0.0)


def _chart(canvas: Canvas, box: Box, flight: SideBySide, longest: int) -> None:
    """Draw the coverage over the steps, from nothing to all."""
    top, left, height, width = box
    bottom = top + height
    for level in LEVELS:
        line = bottom - level * height
        stroke(canvas, [(left, line), (left + width, line)], TROUGH, 1)
        write(canvas, (left, line - 7), floored_percent(level).replace(".0", ""), 11, FAINT, anchor=0.0)
    stroke(canvas, [(left, bottom), (left + width, bottom)], HAIRLINE, 1)
    steps = np.arange(len(flight.coverage)) / longest
    points = np.column_stack((left + 2 + steps * (width - 4), bottom - np.array(flight.coverage) * height))
    stroke(canvas, points, BAR, 2.5)
    disc(canvas, (float(points[-1, 0]), float(points[-1, 1])), 4.0, BAR)
    line = bottom + NUMBERS / 2 + 2
    write(canvas, (left, line), f"step {flight.scene.step:,}", 13, FAINT, anchor=0.0)
    write(canvas, (left + width, line), f"{longest:,}", 13, FAINT, anchor=1.0)
