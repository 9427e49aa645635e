"""Cells to pixels: a pixel gets the mean colour of the cells under it, so that no scale causes aliasing.

Compiled: at scales that are no whole number, numpy's cumulative sums need 5 to 14 times as long.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel


def resample(cells: NDArray[np.uint8], out: NDArray[np.uint8]) -> None:
    """Fill ``out`` (h, w, 3) uint8 with an image of ``cells`` (H, W, 3) uint8, larger or smaller."""
    _lay(np.ascontiguousarray(cells), out, *_spans(cells.shape[0], out.shape[0]), *_spans(cells.shape[1], out.shape[1]))


def _spans(cells: int, pixels: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the first and last cell under each pixel (pixels, 2) and how much of those two it covers (pixels, 2)."""
    edges = np.arange(pixels + 1) * (cells / pixels)
    edges = np.where(np.abs(edges - np.rint(edges)) < 1e-6, np.rint(edges), edges)
    first = np.floor(edges[:-1]).astype(np.int64)
    last = np.maximum(np.minimum(np.ceil(edges[1:]).astype(np.int64) - 1, cells - 1), first)
    head = np.minimum(first + 1, edges[1:]) - edges[:-1]
    return np.stack((first, last), axis=1), np.stack((head, edges[1:] - last), axis=1)


@kernel()
def _lay(
    cells: np.ndarray, out: np.ndarray, rows: np.ndarray, down: np.ndarray, cols: np.ndarray, across: np.ndarray
) -> None:
    for y in range(out.shape[0]):
        top, bottom = rows[y, 0], rows[y, 1]
        for x in range(out.shape[1]):
            left, right = cols[x, 0], cols[x, 1]
            if top == bottom and left == right:
                for k in range(3):
                    out[y, x, k] = cells[top, left, k]
                continue
            red, green, blue, whole = 0.0, 0.0, 0.0, 0.0
            for r in range(top, bottom + 1):
                high = down[y, 0] if r == top else (down[y, 1] if r == bottom else 1.0)
                for c in range(left, right + 1):
                    share = high * (across[x, 0] if c == left else (across[x, 1] if c == right else 1.0))
                    red += share * cells[r, c, 0]
                    green += share * cells[r, c, 1]
                    blue += share * cells[r, c, 2]
                    whole += share
            out[y, x, 0] = np.uint8(red / whole + 0.5)
            out[y, x, 1] = np.uint8(green / whole + 0.5)
            out[y, x, 2] = np.uint8(blue / whole + 0.5)
