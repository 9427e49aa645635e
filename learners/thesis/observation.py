"""The thesis's observation: one image of the whole map, the UAVs painted into it (its Table 3.1).

Images are kept as codes, one byte a cell: 0 unknown, 1 free, 2 obstacle, and 3 plus a UAV's number. The network
sees a code's level: 0, 0.3, 0.5, and the number plus 1.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import OCCUPIED
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.policies.view import View

#: The first UAV's code; a number above 252 is painted as 252.
FIRST = 3
#: (256,) float32: what the network sees of each code.
LEVELS = np.concatenate([[0.0, 0.3, 0.5], np.arange(1.0, 254.0)]).astype(np.float32)


def painted(view: View, agent: int, *, identity: bool) -> NDArray[np.uint8]:
    """Return the image (H, W) of what UAV ``agent`` knows: the map, mates where last heard, itself on top."""
    image = view.belief.copy()
    for mate in view.mates:
        image[mate.cell] = code(1 if identity else mate.agent)
    image[view.cell] = code(0 if identity else agent)
    return image


def code(number: int) -> int:
    """Return the code that a UAV of that number is painted with."""
    return min(FIRST + number, 255)


@kernel()
def paint_all(
    belief: np.ndarray,
    cell: np.ndarray,
    heard_step: np.ndarray,
    heard_cell: np.ndarray,
    identity: bool,
    columns: np.ndarray,
    team: int,
    images: np.ndarray,
) -> None:
    """Paint the images (C, H, W) of some columns, b * team + n for UAV n of episode b, as :func:`painted` does.

    ``belief`` is (B, N, H, W), ``cell`` (B, N, 2), ``heard_step`` (B, N, N), below 0 for never, and ``heard_cell``
    (B, N, N, 2): the world's state.
    """
    for column in columns:
        b, n = divmod(column, team)
        images[column] = belief[b, n]
        for mate in range(team):
            if heard_step[b, n, mate] >= 0:
                row, col = heard_cell[b, n, mate, 0], heard_cell[b, n, mate, 1]
                images[column, row, col] = min(FIRST + (1 if identity else mate), 255)
        images[column, cell[b, n, 0], cell[b, n, 1]] = min(FIRST + (0 if identity else n), 255)


def window(images: Sequence[Belief], cell: Cell, shape: tuple[int, int], out: NDArray[np.uint8]) -> None:
    """Fill ``out`` (K, *shape) with the part of K images (H, W) around a cell that a network of that shape sees.

    Where the map is larger, the window has the cell in its middle, or lies at the map's border; where it is
    smaller, obstacles are around it. On a map of the shape itself this is the whole image.
    """
    out[:] = OCCUPIED
    rows = _span(images[0].shape[0], cell[0], shape[0])
    cols = _span(images[0].shape[1], cell[1], shape[1])
    for image, frame in zip(images, out, strict=True):
        frame[rows[1], cols[1]] = image[rows[0], cols[0]]


def _span(cells: int, at: int, wide: int) -> tuple[slice, slice]:
    """Return what of an axis of the map is seen, and where in the window it is."""
    if cells <= wide:
        first = (wide - cells) // 2
        return slice(0, cells), slice(first, first + cells)
    first = min(max(at - wide // 2, 0), cells - wide)
    return slice(first, first + wide), slice(0, wide)
