"""Colours: the map in greys, the UAVs in hues that colour-blind readers can distinguish.

The first UAVs have the colours of Okabe and Ito (2008) as in the report's figures, without yellow, which vanishes on
white. Each further colour has the largest distance in Oklab (Ottosson 2020) to all before it, the minimum over normal
sight and red- and green-blindness as simulated by Vienot, Brettel and Mollon (1999).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN

#: RGB colours of the page, of text, of lesser text and of the hairlines around maps.
PAGE, INK, FAINT, HAIRLINE = (255, 255, 255), (24, 28, 36), (104, 112, 124), (150, 157, 168)
#: RGB of the coverage bar and of the part of it that is missing.
BAR, TROUGH = (0, 143, 104), (226, 229, 234)

#: (3, 3) uint8 RGB of unknown, free and occupied cells on a map, in the order of the cell values.
KNOWN = np.zeros((3, 3), np.uint8)
KNOWN[UNKNOWN], KNOWN[FREE], KNOWN[OCCUPIED] = (193, 198, 206), (255, 255, 255), (46, 52, 64)
#: The same for the part of the true map that no UAV knows yet.
HIDDEN = KNOWN.copy()
HIDDEN[FREE], HIDDEN[OCCUPIED] = (193, 198, 206), (163, 169, 180)
#: RGB of cells that no UAV knows yet and that are occupied in the prior map alone, and in the true map alone.
ONLY_PRIOR, ONLY_TRUTH = (178, 166, 214), (226, 180, 142)
#: RGB of cells that the team's map shows wrongly, as occupied and as free.
FALSE_OCCUPIED, FALSE_FREE = (205, 52, 73), (247, 168, 182)
#: RGB of the cross over a UAV that a failure has stopped.
STOP = (190, 30, 45)

_FIRST = ("0072b2", "d55e00", "008f68", "b8578e", "c98a00", "3d9fd6")
#: Linear RGB as a viewer without red or green cones sees it.
_SIGHTS = (
    np.eye(3),
    np.array([(0.11238, 0.88762, 0.0), (0.11238, 0.88762, 0.0), (0.00401, -0.00401, 1.0)]),
    np.array([(0.29275, 0.70725, 0.0), (0.29275, 0.70725, 0.0), (-0.02234, 0.02234, 1.0)]),
)
_TO_LMS = np.array([(0.41222, 0.53633, 0.05145), (0.21190, 0.68070, 0.10740), (0.08830, 0.28172, 0.62998)])
_TO_LAB = np.array([(0.21045, 0.79362, -0.00407), (1.97800, -2.42859, 0.45060), (0.02590, 0.78277, -0.80868)])


@lru_cache(maxsize=8)
def uav_colours(team: int) -> NDArray[np.uint8]:
    """Return (team, 3) uint8 RGB, read-only; a UAV has the same colour in a team of any size."""
    chosen = [np.array(list(bytes.fromhex(colour)), np.uint8) for colour in _FIRST]
    candidates = _candidates()
    lab = _seen(candidates)
    distance = np.full(len(candidates), np.inf)
    for colour in chosen:
        distance = np.minimum(distance, _distances(lab, _seen(colour[None])))
    while len(chosen) < team:
        best = int(np.argmax(distance))
        chosen.append(candidates[best])
        distance = np.minimum(distance, _distances(lab, lab[:, best : best + 1]))
    colours = np.stack(chosen[:team])
    colours.setflags(write=False)
    return colours


def paler(colours: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return colours (..., 3) uint8 as those of UAVs that have ended."""
    return np.asarray(0.42 * colours + 0.58 * 232, np.uint8)


def ink_on(colour: NDArray[np.uint8]) -> tuple[int, int, int]:
    """Return the colour of writing on a disc of ``colour`` (3,)."""
    return PAGE if colour @ np.array([0.299, 0.587, 0.114]) < 165 else INK


def _candidates() -> NDArray[np.uint8]:
    """Return (M, 3) uint8 RGB colours of medium lightness and chroma."""
    levels = np.arange(0, 256, 15)
    rgb = np.stack(np.meshgrid(levels, levels, levels, indexing="ij"), axis=-1).reshape(-1, 3).astype(np.uint8)
    lightness, a, b = _seen(rgb)[0].T
    chroma = np.hypot(a, b)
    return np.asarray(rgb[(lightness > 0.38) & (lightness < 0.8) & (chroma > 0.07) & (chroma < 0.19)])


def _seen(rgb: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return (3, M, 3) Oklab of (M, 3) uint8 RGB, for each kind of sight."""
    linear = (rgb / 255.0) ** 2.2
    return np.stack([np.cbrt(np.clip(linear @ sight.T, 0, 1) @ _TO_LMS.T) @ _TO_LAB.T for sight in _SIGHTS])


def _distances(some: NDArray[np.float64], one: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.linalg.norm(some - one, axis=2).min(axis=0))
