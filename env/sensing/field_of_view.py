"""The part of its surroundings that a sensor with a limited field of view sees, by the direction that it faces."""

from __future__ import annotations

from math import cos, radians, sqrt

from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.env.grid.compiled import inner

#: Degrees of a sensor that sees all around.
ALL_AROUND = 360.0


def least_cosine(degrees: float) -> float:
    """Return the least cosine of the angle between the heading and a cell in view; below -1 for all around."""
    return -2.0 if degrees >= ALL_AROUND else cos(radians(degrees / 2)) - 1e-9


@inner()
def is_in_view(cosine: float, heading: int, rows: int, cols: int) -> bool:
    """Tell whether a cell that many rows and columns away is a neighbour or in the field of view.

    ``cosine`` is a :func:`least_cosine`, ``heading`` the move whose direction the sensor faces.
    """
    if max(abs(rows), abs(cols)) <= 1 or cosine < -1.0:
        return True
    ahead = rows * MOVES[heading, 0] + cols * MOVES[heading, 1]
    return bool(ahead >= cosine * sqrt(rows * rows + cols * cols))
