"""The grid: cell values, moves, and the compiled floods that everything else is built from.

Cells are (row, column). A belief map is ``(H, W) uint8`` with the values below; a true map uses the same
values without ``UNKNOWN``.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Distances, Mask
from indoor_explorers.env.grid.compiled import kernel, leaf

UNKNOWN, FREE, OCCUPIED = np.uint8(0), np.uint8(1), np.uint8(2)
UNREACHABLE = np.int32(2**30)


class Action(IntEnum):
    """The five actions of a UAV, numbered as in the thesis (Table 3.2)."""

    DOWN = 0
    LEFT = 1
    UP = 2
    RIGHT = 3
    STAY = 4


#: (5, 2) row and column change of each action.
MOVES = np.array([(1, 0), (0, -1), (-1, 0), (0, 1), (0, 0)], dtype=np.int64)


@leaf()
def spread(belief: np.ndarray, through: np.uint8, tail: int, queue: np.ndarray, out: np.ndarray) -> int:
    """Flood ``out`` (H, W) int32 with steps through cells that hold ``through``; return cells reached.

    It goes on from the first ``tail`` flat indices of ``queue``, (H*W,) int32, in order of their steps, which ``out``
    holds; other cells hold more than they can be away. Reached cells are added to the queue in order of distance.
    """
    height, width = belief.shape
    head = 0
    while head < tail:
        r, c = divmod(queue[head], width)
        head += 1
        d = out[r, c] + 1
        for k in range(4):
            rr, cc = r + MOVES[k, 0], c + MOVES[k, 1]
            if 0 <= rr < height and 0 <= cc < width and belief[rr, cc] == through and out[rr, cc] > d:
                out[rr, cc] = d
                queue[tail] = rr * width + cc
                tail += 1
    return tail


@leaf()
def distances_from(belief: np.ndarray, row: int, col: int, queue: np.ndarray, out: np.ndarray) -> int:
    """Flood ``out`` (H, W) int32 with steps from (row, col) through ``FREE`` cells; return cells reached.

    ``queue`` is scratch, (H*W,) int32; its first entries are the reached cells in order of distance, as
    flat indices. Unreached cells hold ``UNREACHABLE``. The start counts as free whatever it holds.
    """
    out[:] = UNREACHABLE
    out[row, col] = 0
    queue[0] = row * belief.shape[1] + col
    return spread(belief, FREE, 1, queue, out)


def distance_field(belief: Belief, cell: tuple[int, int]) -> Distances:
    """Return the (H, W) int32 field of steps from ``cell`` through known free cells.

    Cells that cannot be reached hold :data:`UNREACHABLE`.
    """
    out = np.empty(belief.shape, np.int32)
    distances_from(belief, cell[0], cell[1], np.empty(belief.size, np.int32), out)
    return out


@leaf()
def touches_unknown(belief: np.ndarray, row: int, col: int) -> bool:
    """Tell whether a cell is 4-adjacent to an unknown one; a free cell that is, is a frontier (Yamauchi 1997)."""
    height, width = belief.shape
    return bool(
        (row > 0 and belief[row - 1, col] == UNKNOWN)
        or (col > 0 and belief[row, col - 1] == UNKNOWN)
        or (row + 1 < height and belief[row + 1, col] == UNKNOWN)
        or (col + 1 < width and belief[row, col + 1] == UNKNOWN)
    )


@kernel()
def frontier_mask(belief: np.ndarray) -> np.ndarray:
    """Return the (H, W) bool mask of frontier cells: known free, 4-adjacent to unknown."""
    height, width = belief.shape
    mask = np.zeros((height, width), np.bool_)
    for r in range(height):
        for c in range(width):
            mask[r, c] = belief[r, c] == FREE and touches_unknown(belief, r, c)
    return mask


@leaf()
def step_towards(field: np.ndarray, row: int, col: int) -> int:
    """Return the first action of a shortest path from the origin of ``field`` to (row, col).

    ``field`` is a distance field flooded from the UAV's own cell; the path is traced back from the
    target, preferring the moves in the order of :class:`Action`. ``Action.STAY`` when the target is the
    origin or cannot be reached.
    """
    height, width = field.shape
    if field[row, col] >= UNREACHABLE:
        return 4
    action = 4
    while field[row, col] > 0:
        for k in range(4):
            rr, cc = row - MOVES[k, 0], col - MOVES[k, 1]
            if 0 <= rr < height and 0 <= cc < width and field[rr, cc] == field[row, col] - 1:
                row, col, action = rr, cc, k
                break
    return action


def connected_parts(free: Mask) -> tuple[Distances, np.ndarray]:
    """Label the 4-connected parts of a (H, W) bool mask; return (labels, cells in each label)."""
    from scipy import ndimage

    labels, count = ndimage.label(free)
    return labels.astype(np.int32), np.bincount(labels.ravel(), minlength=count + 1)


@leaf()
def flood(truth: np.ndarray, row: int, col: int, number: int, part: np.ndarray, queue: np.ndarray) -> int:
    """Write ``number`` into ``part`` (H, W) int32 at every free cell connected to (row, col) where it holds 0.

    Returns how many those are; their flat indices are the first entries of ``queue`` (H*W,) int32, nearest first.
    """
    height, width = truth.shape
    part[row, col] = number
    queue[0] = row * width + col
    head, tail = 0, 1
    while head < tail:
        r, c = divmod(queue[head], width)
        head += 1
        for k in range(4):
            rr, cc = r + MOVES[k, 0], c + MOVES[k, 1]
            if 0 <= rr < height and 0 <= cc < width and truth[rr, cc] == FREE and part[rr, cc] == 0:
                part[rr, cc] = number
                queue[tail] = rr * width + cc
                tail += 1
    return tail


@leaf()
def mark_largest_part(truth: np.ndarray, part: np.ndarray, queue: np.ndarray) -> int:
    """Write 1 into ``part`` (H, W) int32 on the largest connected free part, 0 elsewhere; return its size.

    Among parts of one size the first in reading order counts. ``queue`` (H*W,) int32 is scratch.
    """
    height, width = truth.shape
    part[:] = 0
    number = largest = most = 0
    for row in range(height):
        for col in range(width):
            if truth[row, col] == FREE and part[row, col] == 0:
                number += 1
                size = flood(truth, row, col, number, part, queue)
                if size > most:
                    largest, most = number, size
    for row in range(height):
        for col in range(width):
            part[row, col] = most > 0 and part[row, col] == largest
    return most


def largest_part(free: Mask) -> Mask:
    """Return the mask of the largest 4-connected part of ``free``; all False when nothing is free."""
    part = np.empty(free.shape, np.int32)
    mark_largest_part(free.astype(np.uint8) * FREE, part, np.empty(free.size, np.int32))
    return np.asarray(part == 1)
