"""Connected parts of a map: cells that can be reached from each other by moves."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.arrays import Distances, Mask
from indoor_explorers.env.grid.cells import FREE, MOVES
from indoor_explorers.env.grid.compiled import leaf


def connected_parts(free: Mask) -> tuple[Distances, np.ndarray]:
    """Label the 4-connected parts of a (H, W) bool mask; return (labels, cells in each label)."""
    from scipy import ndimage

    labels, count = ndimage.label(free)
    return labels.astype(np.int32), np.bincount(labels.ravel(), minlength=count + 1)


@leaf(entry=False)
def label_part(truth: np.ndarray, row: int, col: int, label: int, labels: np.ndarray, queue: np.ndarray) -> int:
    """Write ``label`` into ``labels`` (H, W) int32 at every free cell connected to (row, col) that holds 0.

    Returns how many those are; their flat indices are the first entries of ``queue`` (H*W,) int32, nearest first.
    """
    height, width = truth.shape
    labels[row, col] = label
    queue[0] = row * width + col
    head, tail = 0, 1
    while head < tail:
        r, c = divmod(queue[head], width)
        head += 1
        for k in range(4):
            rr, cc = r + MOVES[k, 0], c + MOVES[k, 1]
            if 0 <= rr < height and 0 <= cc < width and truth[rr, cc] == FREE and labels[rr, cc] == 0:
                labels[rr, cc] = label
                queue[tail] = rr * width + cc
                tail += 1
    return tail


@leaf()
def mark_largest_part(truth: np.ndarray, part: np.ndarray, queue: np.ndarray) -> int:
    """Write 1 into ``part`` (H, W) int32 on the largest connected free part, 0 elsewhere; return its size.

    Among parts of equal size, the first in reading order is taken. ``queue`` (H*W,) int32 is scratch.
    """
    height, width = truth.shape
    part[:] = 0
    label = largest = most = 0
    for row in range(height):
        for col in range(width):
            if truth[row, col] == FREE and part[row, col] == 0:
                label += 1
                size = label_part(truth, row, col, label, part, queue)
                if size > most:
                    largest, most = label, size
    for row in range(height):
        for col in range(width):
            part[row, col] = most > 0 and part[row, col] == largest
    return most


def largest_part(free: Mask) -> Mask:
    """Return the mask of the largest 4-connected part of ``free``; all False when nothing is free."""
    part = np.empty(free.shape, np.int32)
    mark_largest_part(free.astype(np.uint8) * FREE, part, np.empty(free.size, np.int32))
    return np.asarray(part == 1)
