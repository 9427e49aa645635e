"""The field of view of a lidar that does not see all around: a sector about the heading, and the eight neighbours."""

from __future__ import annotations

from math import cos, radians, sqrt

from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.env.grid.compiled import inner

#: Field of view without a limit, in degrees.
ALL_AROUND = 360.0


def least_cosine(degrees: float) -> float:
    """Return the least cosine of the angle between the heading and a cell in view; below -1 for all around."""
    return -2.0 if degrees >= ALL_AROUND else cos(radians(degrees / 2)) - 1e-9


@inner()
def is_in_view(least: float, heading: int, rows: int, cols: int) -> bool:
    """Tell whether a cell that many rows and columns away is a neighbour or in the field of view.

    ``least`` is that of :func:`least_cosine`, ``heading`` the action whose direction the UAV faces.
    """
    if max(abs(rows), abs(cols)) <= 1 or least < -1.0:
        return True
    ahead = rows * MOVES[heading, 0] + cols * MOVES[heading, 1]
    return bool(ahead >= least * sqrt(rows * rows + cols * cols))
