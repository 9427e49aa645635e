"""The layout of a map: its free cells up to rotation, mirror image, border and scale; how far two layouts overlap."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from math import gcd

import numpy as np

from indoor_explorers.env.grid.arrays import Mask

#: The beginning of the digest of a layout; the digest of one map has none.
PREFIX = "layout-"


def layout_digest(free: Mask) -> str:
    """Return a short hash of a (H, W) mask of free cells that is the same for all equal layouts.

    Equal are maps that differ by a quarter turn or a mirror image, by rows and columns without free cells around the
    free ones, or by a whole number of cells for each cell.
    """
    return PREFIX + mask_digest(symmetries(coarsest(cropped_to_free(free))))


def mask_digest(views: Iterable[Mask]) -> str:
    """Return a short hash that is the same whichever of some equivalent (H, W) masks comes first."""
    shape, cells = min((view.shape, np.packbits(view).tobytes()) for view in views)
    return hashlib.sha256(repr(shape).encode() + cells).hexdigest()[:16]


def cropped_to_free(free: Mask) -> Mask:
    """Return the smallest rectangle of a (H, W) mask that holds all its free cells; there must be one."""
    rows, columns = np.flatnonzero(free.any(axis=1)), np.flatnonzero(free.any(axis=0))
    return free[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]


def coarsest(free: Mask) -> Mask:
    """Return a (H, W) mask with one cell for each square block of equal cells, of the largest size that fits."""
    height, width = free.shape
    changes = np.flatnonzero((free[1:] != free[:-1]).any(axis=1)) + 1
    across = np.flatnonzero((free[:, 1:] != free[:, :-1]).any(axis=0)) + 1
    size = gcd(height, width, *changes.tolist(), *across.tolist())
    return free[::size, ::size]


def symmetries(grid: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the eight rotations and mirror images of a (H, W) array, the array itself first."""
    for turns in range(4):
        turned = np.rot90(grid, turns)
        yield turned
        yield turned[:, ::-1]


def overlap(one: Mask, other: Mask) -> float:
    """Return the free cells that two layouts share, as a share of the cells that are free in either: 0 to 1.

    Both are cropped to their free cells, and ``other`` is stretched to the shape of ``one``, in the best of its eight
    rotations and mirror images.
    """
    base = cropped_to_free(one)
    views = symmetries(cropped_to_free(other))
    return max(float((base & view).sum() / (base | view).sum()) for view in (_stretched(v, base.shape) for v in views))


def _stretched(grid: Mask, shape: tuple[int, int]) -> Mask:
    """Return a mask of another (H, W) shape, each cell that of the nearest one."""
    rows, columns = (np.arange(new) * old // new for new, old in zip(shape, grid.shape, strict=True))
    return grid[np.ix_(rows, columns)]
