"""Exact line of sight on a grid, and what a lidar scan reveals.

A free cell is seen when the segment between the two cell centres crosses no obstacle; an obstacle cell
is seen when the segment from the sensor to the midpoint of one of its sides that faces a free cell
crosses none. Touching the corner of one obstacle does not block, passing between two that touch at a
corner does. All of it is integer arithmetic: coordinates are doubled, so that centres are even and sides
odd.

The cells that each segment crosses depend on the range alone. They are kept as one prefix tree (a trie)
laid out in depth-first order: when a cell blocks, the whole subtree behind it is skipped, so a scan costs
about as much as the cells it sees.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Belief
from indoor_explorers.env.grid import FREE, OCCUPIED, UNKNOWN

#: What ends at a node of the tree: nothing, a sight line to a cell's centre, or one to a side.
THROUGH, CENTRE, SIDE = 0, 1, 2


class Beams(NamedTuple):
    """Every sight line of one lidar range as a depth-first prefix tree of K nodes.

    A node stands for one cell on the way, or for a pair of cells that the line squeezes between at their
    common corner (blocked only when both are occupied; for a single cell both entries are the same).
    """

    first: NDArray[np.int64]
    """(K, 2) row and column offset of the cell, or of the pair's first cell."""
    second: NDArray[np.int64]
    """(K, 2) the same for the pair's second cell."""
    skip: NDArray[np.int64]
    """(K,) the node to go on with when this one is blocked or off the map."""
    ends: NDArray[np.int64]
    """(K + 1,) node k's sight lines are ``target[ends[k]:ends[k + 1]]``."""
    target: NDArray[np.int64]
    """(T, 2) row and column offset of the cell that a sight line is for."""
    kind: NDArray[np.int64]
    """(T,) ``CENTRE`` or ``SIDE``."""


@njit(cache=True)
def _crossed(end_row: int, end_col: int, path: np.ndarray) -> int:
    """List the cells that the segment (0, 0) -> (end_row, end_col), in half cells, runs through.

    Fills ``path`` (., 4) with (row, col, row, col) per entry, two different cells for a corner squeezed
    through, and returns the number of entries. The sensor's own cell is left out.
    """
    down, right = (1 if end_row > 0 else -1), (1 if end_col > 0 else -1)
    height, width = abs(end_row), abs(end_col)
    row = col = count = 0
    while True:
        # The next horizontal cell border is crossed at t = (2 row + 1) / height, the next vertical one at
        # (2 col + 1) / width; compare them without dividing.
        horizontal = (2 * row + 1) * width
        vertical = (2 * col + 1) * height
        row_left = 2 * row + 1 < height
        col_left = 2 * col + 1 < width
        if not row_left and not col_left:
            return count
        if row_left and col_left and horizontal == vertical:
            path[count, 0], path[count, 1] = down * (row + 1), right * col
            path[count, 2], path[count, 3] = down * row, right * (col + 1)
            count += 1
            row += 1
            col += 1
        elif row_left and (not col_left or horizontal < vertical):
            row += 1
        else:
            col += 1
        path[count, 0] = path[count, 2] = down * row
        path[count, 1] = path[count, 3] = right * col
        count += 1


@njit(cache=True)
def _grow(targets: np.ndarray, nodes: np.ndarray, child: np.ndarray, sibling: np.ndarray, ends_at: np.ndarray) -> int:
    """Insert the sight line of every (row, col, half row, half col) target into a prefix tree.

    ``nodes`` (., 4) receives the tree's entries, ``child`` and ``sibling`` its links, ``ends_at`` (T,) the
    node where each line ends. Node 0 is the sensor's own cell. Returns the number of nodes.
    """
    path = np.empty((nodes.shape[0], 4), np.int64)
    nodes[0] = 0
    child[:] = -1
    sibling[:] = -1
    count = 1
    for t in range(targets.shape[0]):
        at = 0
        for k in range(_crossed(targets[t, 2], targets[t, 3], path)):
            last, walk = -1, child[at]
            while walk >= 0 and not (
                nodes[walk, 0] == path[k, 0]
                and nodes[walk, 1] == path[k, 1]
                and nodes[walk, 2] == path[k, 2]
                and nodes[walk, 3] == path[k, 3]
            ):
                last, walk = walk, sibling[walk]
            if walk < 0:
                walk = count
                if count >= nodes.shape[0]:
                    return -1
                nodes[walk] = path[k]
                count += 1
                if last < 0:
                    child[at] = walk
                else:
                    sibling[last] = walk
            at = walk
        ends_at[t] = at
    return count


@njit(cache=True)
def _depth_first(child: np.ndarray, sibling: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return (order, skip): the nodes in depth-first order, and for each place the place after its subtree."""
    order = np.empty(count, np.int64)
    skip = np.empty(count, np.int64)
    stack = np.empty(count + 1, np.int64)
    place_of = np.empty(count, np.int64)
    stack[0] = 0
    top, place = 1, 0
    while top > 0:
        top -= 1
        node = stack[top]
        if node < 0:  # a marker: the subtree of node -node - 1 ends here
            skip[place_of[-node - 1]] = place
            continue
        order[place] = node
        place_of[node] = place
        place += 1
        if sibling[node] >= 0:
            stack[top] = sibling[node]
            top += 1
        stack[top] = -node - 1
        top += 1
        if child[node] >= 0:
            stack[top] = child[node]
            top += 1
        if top + 3 > stack.shape[0]:
            grown = np.empty(2 * stack.shape[0] + 3, np.int64)
            grown[:top] = stack[:top]
            stack = grown
    return order, skip


def _targets(lidar_range: float) -> NDArray[np.int64]:
    """List the sight lines of a range: (row, col, half row, half col), nearest cells first."""
    reach = int(np.floor(lidar_range + 1e-9))
    lines = []
    for row in range(-reach, reach + 1):
        for col in range(-reach, reach + 1):
            if 0 < row * row + col * col <= lidar_range * lidar_range + 1e-9:
                lines.append((row, col, 2 * row, 2 * col))
                if row:
                    lines.append((row, col, 2 * row - int(np.sign(row)), 2 * col))
                if col:
                    lines.append((row, col, 2 * row, 2 * col - int(np.sign(col))))
    lines.sort(key=lambda line: (line[0] ** 2 + line[1] ** 2, line))
    return np.array(lines, np.int64).reshape(-1, 4)


@lru_cache(maxsize=32)
def beams(lidar_range: float) -> Beams:
    """Return the sight lines of a lidar range in cells; a cell is in range when its centre is."""
    targets = _targets(lidar_range)
    capacity = 64 + 4 * len(targets)
    while True:
        nodes = np.empty((capacity, 4), np.int64)
        child, sibling = np.empty(capacity, np.int64), np.empty(capacity, np.int64)
        ends_at = np.empty(len(targets), np.int64)
        count = _grow(targets, nodes, child, sibling, ends_at)
        if count > 0:
            break
        capacity *= 2
    order, skip = _depth_first(child, sibling, count)
    place_of = np.empty(count, np.int64)
    place_of[order] = np.arange(count)
    place = place_of[ends_at]
    by_place = np.argsort(place, kind="stable")
    kind = np.where((targets[:, 2] % 2 == 0) & (targets[:, 3] % 2 == 0), CENTRE, SIDE)
    return Beams(
        first=np.ascontiguousarray(nodes[order, :2]),
        second=np.ascontiguousarray(nodes[order, 2:]),
        skip=skip,
        ends=np.searchsorted(place[by_place], np.arange(count + 1)),
        target=np.ascontiguousarray(targets[by_place, :2]),
        kind=kind[by_place],
    )


@njit(cache=True, nogil=True)
def visible_cells(occupancy: np.ndarray, row: int, col: int, beams: Beams, out: np.ndarray) -> int:
    """List the cells seen from (row, col): fills ``out`` with flat indices and returns how many.

    ``occupancy`` is (H, W) uint8, C-contiguous, and only ``OCCUPIED`` blocks, so on a belief map unknown cells
    are transparent. The own cell comes first. A cell may be listed twice (an obstacle seen by two of its
    sides). ``out`` needs room for one entry more than there are sight lines.
    """
    height, width = occupancy.shape
    cells = occupancy.reshape(height * width)
    out[0] = row * width + col
    seen = 1
    node, count = 0, beams.skip.shape[0]
    while node < count:
        r, c = row + beams.first[node, 0], col + beams.first[node, 1]
        rr, cc = row + beams.second[node, 0], col + beams.second[node, 1]
        if min(r, rr) < 0 or max(r, rr) >= height or min(c, cc) < 0 or max(c, cc) >= width:
            node = beams.skip[node]
            continue
        if cells[r * width + c] == OCCUPIED and cells[rr * width + cc] == OCCUPIED:
            node = beams.skip[node]
            continue
        for t in range(beams.ends[node], beams.ends[node + 1]):
            tr, tc = row + beams.target[t, 0], col + beams.target[t, 1]
            inside = 0 <= tr < height and 0 <= tc < width
            if beams.kind[t] == CENTRE or (inside and cells[tr * width + tc] == OCCUPIED):
                out[seen] = tr * width + tc
                seen += 1
        node += 1
    return seen


@njit(cache=True, nogil=True)
def unknown_in_view(belief: np.ndarray, row: int, col: int, beams: Beams) -> int:
    """Count the unknown cells that a scan at (row, col) could reveal, unknown taken as transparent."""
    height, width = belief.shape
    gain = 0
    node, count = 0, beams.skip.shape[0]
    while node < count:
        r, c = row + beams.first[node, 0], col + beams.first[node, 1]
        rr, cc = row + beams.second[node, 0], col + beams.second[node, 1]
        if (r < 0 or r >= height or c < 0 or c >= width or rr < 0 or rr >= height or cc < 0 or cc >= width) or (
            belief[r, c] == OCCUPIED and belief[rr, cc] == OCCUPIED
        ):
            node = beams.skip[node]
            continue
        for t in range(beams.ends[node], beams.ends[node + 1]):
            if beams.kind[t] == CENTRE and belief[row + beams.target[t, 0], col + beams.target[t, 1]] == UNKNOWN:
                gain += 1
        node += 1
    return gain


def view_gain(belief: Belief, cell: tuple[int, int], lidar_range: float) -> int:
    """Return how many unknown cells are visible from ``cell`` on a (H, W) belief map."""
    return int(unknown_in_view(belief, cell[0], cell[1], beams(float(lidar_range))))


def scan(truth: Belief, cell: tuple[int, int], lidar_range: float) -> Belief:
    """Return the (H, W) belief after one scan of ``truth`` at ``cell``, everything else unknown."""
    lines = beams(float(lidar_range))
    seen = np.empty(len(lines.target) + 1, np.int64)
    count = visible_cells(truth, cell[0], cell[1], lines, seen)
    belief = np.full(truth.shape, UNKNOWN, np.uint8)
    belief.flat[seen[:count]] = np.where(truth.flat[seen[:count]] == OCCUPIED, OCCUPIED, FREE)
    return belief
