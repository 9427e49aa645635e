"""Why a UAV flies where it does: way, candidates and goal on the team's map, and the words and numbers below it."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.levels import Levels
from indoor_explorers.env.policies.explanation import Explanation, cell_text, sentence
from indoor_explorers.env.rendering.layout import MARGIN
from indoor_explorers.env.rendering.overlays import Cells, Chart, Colour, changes
from indoor_explorers.env.rendering.palette import FAINT, INK, PAGE
from indoor_explorers.env.rendering.primitives import Canvas, fitting, stroke, text_width, write
from indoor_explorers.env.rendering.scene import Told

#: Most candidates that are shown: the best.
SHOWN = 6
#: Pixels of a line below the picture, of its letters, and between columns.
LINE, SIZE, APART = 20, 14, 18
#: Pixels of all lines: a sentence, what the scores are, a heading, and the candidates.
HEIGHT = LINE * (3 + SHOWN) + MARGIN


def mark(chart: Chart, told: Explanation, colour: Colour) -> None:
    """Draw the way, the candidates by rank, and the goal, which is filled."""
    if len(told.path) > 1:
        cells = np.array(told.path)
        way, seen = chart.middles(cells), np.where(np.diff(chart.level_of(cells)), 0.0, 0.95)
        for width, ink in ((7.0, np.array(PAGE, np.uint8)), (3.5, colour)):
            stroke(chart.inside, way * chart.cell, ink, width, seen)
        changes(chart, cells, colour)
    for rank, each in reversed(list(enumerate(told.candidates[:SHOWN], 1))):
        if each.cell != told.goal:
            _box(chart, np.array(each.cell), str(rank), PAGE, colour)
    if told.goal is not None:
        ranks = [str(rank) for rank, each in enumerate(told.candidates[:SHOWN], 1) if each.cell == told.goal]
        _box(chart, np.array(told.goal), "".join(ranks), colour, PAGE)


def with_words(picture: Canvas, told: Told, colour: Colour, levels: Levels) -> Canvas:
    """Return a picture (h, w, 3) with ``HEIGHT`` more rows that say what is told on a map of some levels."""
    below = np.full((HEIGHT, picture.shape[1], 3), 255, np.uint8)
    room = picture.shape[1] - 2 * MARGIN
    stroke(below, [(MARGIN + 2, 4), (MARGIN + 2, HEIGHT - MARGIN)], colour, 4)
    why = told.explanation
    said = "nothing is told of its last move" if why is None else sentence(why, levels)
    lines = [f"UAV {told.agent}: {said}", f"among, by {why.score}:" if why and why.candidates else ""]
    for place, text in enumerate(lines):
        ink = FAINT if place else INK
        write(below, _start(place), fitting(text, SIZE + 1 - place, room - 12), SIZE + 1 - place, ink, anchor=0.0)
    if why is not None and why.candidates:
        _table(below, why, room, colour, levels)
    return np.concatenate((picture, below))


def _start(line: int) -> tuple[float, float]:
    return MARGIN + 12.0, LINE * (line + 0.5)


def _table(below: Canvas, why: Explanation, room: int, colour: Colour, levels: Levels) -> None:
    """Write a column for rank, cell, score and each part, as far as there is room."""
    candidates = why.candidates[:SHOWN]
    names = list(candidates[0].parts)
    rows = [["", "cell", "score", *names]]
    for rank, each in enumerate(candidates, 1):
        parts = (f"{each.parts.get(name, np.nan):.3g}" for name in names)
        rows.append([str(rank), cell_text(each.cell, levels), f"{each.score:.3g}", *parts])
    right = _start(0)[0]
    for column in zip(*rows, strict=True):
        right += max(text_width(text, SIZE) for text in column)
        if right > room:
            return
        for line, text in enumerate(column):
            chosen = line > 0 and candidates[line - 1].cell == why.goal
            ink = colour if chosen else INK if line else FAINT
            write(below, (right, _start(line + 2)[1]), text, SIZE, ink, anchor=1.0)
        right += APART


def _box(chart: Chart, cell: Cells, text: str, fill: Colour | tuple[int, ...], edge: Colour | tuple[int, ...]) -> None:
    """Draw a square with a number in it."""
    (x, y), half = chart.outer(cell), round(0.9 * chart.radius)
    row, col = round(y), round(x)
    for reach, ink in ((half + 1, PAGE), (half, edge), (half - 2, fill)):
        chart.around[max(0, row - reach) : row + reach, max(0, col - reach) : col + reach] = ink
    if text and half >= 4:
        write(chart.around, (col, row), text, 1.4 * half, np.asarray(edge, np.uint8))
