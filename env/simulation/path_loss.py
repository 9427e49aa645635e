"""The radio of IR2: path loss in the open and through obstacles, with a fading that is drawn once an episode.

Two UAVs are in contact while the loss between them is below 50 dB (sent with -20 dBm, received above -70 dBm)::

    PL = 31 + [40 log10(o) + K, where o > 0] + [20 log10(f / 35) + X, where f >= 35]

``o`` is the length of the way in obstacles and ``f`` the rest of the distance, both in IR2's pixels; K and X are
uniform from 0 to 13 dB. Source: Tan et al., "IR2: Implicit Rendezvous for Robotic Exploration Teams under Sparse
Intermittent Connectivity" (IROS 2024), and the constants of its published code.
"""

from __future__ import annotations

from math import log10, sqrt

import numpy as np

from indoor_explorers.env.grid.compiled import inner
from indoor_explorers.env.grid.lines import obstacles_on_line

#: Loss in dB at the reference distance, and the loss at which contact ends.
REFERENCE_LOSS, MOST_LOSS = 31.0, 50.0
#: The reference distance in pixels.
REFERENCE = 35.0
#: The path loss exponents in the open and in obstacles.
OPEN, OBSTRUCTED = 2.0, 4.0
#: The largest value of K and X in dB.
MOST_FADING = 13.0


@inner()
def is_within_path_loss(
    occupancy: np.ndarray, reach: float, fading: np.ndarray, row: int, col: int, to_row: int, to_col: int
) -> bool:
    """Tell whether two cells of a true map (H, W) are in contact, by the obstacles that either of them counts.

    ``reach`` is the reference distance in cells, ``fading`` (2,) holds K and X in dB.
    """
    distance = sqrt((row - to_row) ** 2 + (col - to_col) ** 2)
    obstacles = min(
        obstacles_on_line(occupancy, row, col, to_row, to_col), obstacles_on_line(occupancy, to_row, to_col, row, col)
    )
    return loss(distance, obstacles, reach, fading) < MOST_LOSS


@inner()
def loss(distance: float, obstacles: int, reach: float, fading: np.ndarray) -> float:
    """Return the path loss in dB over a ``distance`` in cells with so many ``obstacles`` on the way."""
    pixels = REFERENCE / max(reach, 1e-9)
    inside, lost = obstacles * pixels, REFERENCE_LOSS
    outside = distance * pixels - inside
    if inside > 0.0:
        lost += 10.0 * OBSTRUCTED * log10(inside) + fading[0]
    if outside >= REFERENCE:
        lost += 10.0 * OPEN * log10(outside / REFERENCE) + fading[1]
    return lost
