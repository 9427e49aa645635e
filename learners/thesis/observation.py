"""The thesis's observation: one image of the whole map with the UAVs drawn into it (its Table 3.1).

Images are stored as codes, one byte per cell: 0 unknown, 1 free, 2 obstacle, and 3 + a UAV's number. The network
sees each code as a grey level: 0, 0.3, 0.5, and the number + 1.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import OCCUPIED
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.policies.view import View

#: The first UAV's code; a number above 252 is drawn as 252.
FIRST = 3
#: (256,) float32: the grey level of each code.
LEVELS = np.concatenate([[0.0, 0.3, 0.5], np.arange(1.0, 254.0)]).astype(np.float32)


def painted(view: View, agent: int, *, identity: bool) -> NDArray[np.uint8]:
    """Return the image (H, W) of UAV ``agent``: its belief, teammates at their last received cells, itself on top."""
    image = view.belief.copy()
    for mate in view.mates:
        image[mate.cell] = code(1 if identity else mate.agent)
    image[view.cell] = code(0 if identity else agent)
    return image


def code(number: int) -> int:
    """Return the code of a UAV with this number."""
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
    """Draw the images (C, H, W) of some columns as :func:`painted` does; column b * team + n is UAV n of episode b.

    The world's state: ``belief`` (B, N, H, W), ``cell`` (B, N, 2), ``heard_step`` (B, N, N), below 0 for never, and
    ``heard_cell`` (B, N, N, 2).
    """
    for column in columns:
        b, n = divmod(column, team)
        images[column] = belief[b, n]
        for mate in range(team):
            if heard_step[b, n, mate] >= 0:
                row, col = heard_cell[b, n, mate, 0], heard_cell[b, n, mate, 1]
                images[column, row, col] = min(FIRST + (1 if identity else mate), 255)
        images[column, cell[b, n, 0], cell[b, n, 1]] = min(FIRST + (0 if identity else n), 255)


@kernel()
def centre_all(images: np.ndarray, cells: np.ndarray, columns: np.ndarray, out: np.ndarray) -> None:
    """Centre the images (C, H, W) of some columns on their UAVs' ``cells`` (C, 2), see :func:`centred`."""
    height, width = images.shape[1:]
    for k in range(columns.shape[0]):
        column = columns[k]
        out[k] = OCCUPIED
        top, left = out.shape[1] // 2 - cells[column, 0], out.shape[2] // 2 - cells[column, 1]
        for row in range(max(0, -top), min(height, out.shape[1] - top)):
            for col in range(max(0, -left), min(width, out.shape[2] - left)):
                out[k, row + top, col + left] = images[column, row, col]


def centred(image: NDArray[np.uint8], cell: Cell, shape: tuple[int, int]) -> NDArray[np.uint8]:
    """Return a part of an image (H, W) of odd ``shape`` with ``cell`` in its middle, obstacles outside of the map."""
    out = np.empty((1, *shape), np.uint8)
    centre_all(image[None], np.array([cell]), np.zeros(1, np.int64), out)
    return np.asarray(out[0])


def window(images: Sequence[Belief], cell: Cell, shape: tuple[int, int], out: NDArray[np.uint8]) -> None:
    """Fill ``out`` (K, *shape) with a window of K images (H, W) around a cell.

    On a larger map the window is centred on the cell, but stays inside the map. A smaller map is surrounded by
    obstacles. On a map of this shape the window is the whole image.
    """
    out[:] = OCCUPIED
    rows = _span(images[0].shape[0], cell[0], shape[0])
    cols = _span(images[0].shape[1], cell[1], shape[1])
    for image, frame in zip(images, out, strict=True):
        frame[rows[1], cols[1]] = image[rows[0], cols[0]]


def _span(cells: int, at: int, wide: int) -> tuple[slice, slice]:
    """Return, for one axis, the slice of the map that the window shows and its slice of the window."""
    if cells <= wide:
        first = (wide - cells) // 2
        return slice(0, cells), slice(first, first + cells)
    first = min(max(at - wide // 2, 0), cells - wide)
    return slice(first, first + wide), slice(0, wide)
