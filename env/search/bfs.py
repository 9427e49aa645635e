"""Breadth-first search for distances: over a grid or a neighbour table, from one source or many.

All searches visit neighbours in the order of the actions (down, left, up, right, and above and below where the ``rise``
of the map is not 0, see :mod:`indoor_explorers.env.grid.levels`), so their queues contain the reached cells in a fixed
order of increasing distance. Searches for paths are in
:mod:`indoor_explorers.planners.toolbox.navigation.shortest_paths`, those that label parts of a map in
:mod:`indoor_explorers.env.search.connected_parts`.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Distances
from indoor_explorers.env.grid.cells import FREE, MOVES, UNREACHABLE
from indoor_explorers.env.grid.compiled import leaf
from indoor_explorers.env.grid.levels import beside, degree


@leaf(entry=False)
def flood(
    belief: np.ndarray, through: np.uint8, sources: int, queue: np.ndarray, steps: np.ndarray, rise: int = 0
) -> int:
    """Fill ``steps`` (H, W) int32 with distances through cells that hold ``through``; return how many are reached.

    The sources are the first ``sources`` flat cells of ``queue`` (H*W,) int32, in order of their distance, which
    ``steps`` already holds; all other cells hold ``UNREACHABLE``. The queue ends up with all reached cells.
    """
    height, width = belief.shape
    head, tail = 0, sources
    while head < tail:
        r, c = divmod(queue[head], width)
        head += 1
        d = steps[r, c] + 1
        for k in range(degree(rise)):
            rr, cc = beside(r, c, k, rise)
            if 0 <= rr < height and 0 <= cc < width and belief[rr, cc] == through and steps[rr, cc] > d:
                steps[rr, cc] = d
                queue[tail] = rr * width + cc
                tail += 1
    return tail


@leaf()
def distances_from(belief: np.ndarray, row: int, col: int, queue: np.ndarray, steps: np.ndarray, rise: int = 0) -> int:
    """Fill ``steps`` (H, W) int32 with distances from (row, col) through ``FREE`` cells; return how many are reached.

    ``queue`` (H*W,) int32 is scratch; its first entries are the reached cells in order of distance, as flat indices.
    Other cells hold ``UNREACHABLE``. The source may hold any value.
    """
    steps[:] = UNREACHABLE
    steps[row, col] = 0
    queue[0] = row * belief.shape[1] + col
    return flood(belief, FREE, 1, queue, steps, rise)


def distance_field(belief: Belief, cell: tuple[int, int], rise: int = 0) -> Distances:
    """Return the (H, W) int32 distances from ``cell`` through known free cells, in steps.

    Cells that cannot be reached hold :data:`UNREACHABLE`.
    """
    steps = np.empty(belief.shape, np.int32)
    distances_from(belief, cell[0], cell[1], np.empty(belief.size, np.int32), steps, rise)
    return steps


@leaf(entry=False)
def flood_nearby(
    belief: np.ndarray, start: int, target: int, limit: int, queue: np.ndarray, steps: np.ndarray, rise: int = 0
) -> int:
    """Fill ``steps`` (H*W,) int32 with distances from a flat cell through ``FREE`` cells; return how many are reached.

    The search ends at ``target`` (-1 for none) and ``limit`` steps away. ``steps`` must hold ``UNREACHABLE`` before;
    after a small search only the reached cells need a reset, which ``queue`` (H*W,) int32 lists.
    """
    height, width = belief.shape
    steps[start], queue[0] = 0, start
    head, tail = 0, 1
    while head < tail and steps[queue[head]] < limit and (target < 0 or steps[target] == UNREACHABLE):
        row, col = divmod(queue[head], width)
        distance = steps[queue[head]] + 1
        head += 1
        for k in range(degree(rise)):
            r, c = beside(row, col, k, rise)
            if 0 <= r < height and 0 <= c < width and belief[r, c] == FREE and steps[r * width + c] == UNREACHABLE:
                steps[r * width + c] = distance
                queue[tail] = r * width + c
                tail += 1
    return tail


@leaf(entry=False)
def flood_table(neighbours: np.ndarray, sources: int, queue: np.ndarray, steps: np.ndarray) -> int:
    """Fill ``steps`` (M,) int32 with distances over a (M, 4) or (M, 6) neighbour table; return how many it reaches.

    -1 in the table is no neighbour. The sources are the first ``sources`` numbers of ``queue`` (M,) int32, in order of
    their distance, which ``steps`` already holds; all others hold more than any distance.
    """
    head, tail = 0, sources
    while head < tail:
        node = queue[head]
        head += 1
        d = steps[node] + 1
        for k in range(neighbours.shape[1]):
            other = neighbours[node, k]
            if other >= 0 and steps[other] > d:
                steps[other] = d
                queue[tail] = other
                tail += 1
    return tail


@leaf()
def step_towards(steps: np.ndarray, row: int, col: int) -> int:
    """Return the first action of a shortest path from the source of a distance field to (row, col).

    ``steps`` (H, W) are the distances from the UAV's own cell. The path is traced back from the target, preferring the
    moves in the order of :class:`~indoor_explorers.env.grid.cells.Action`. ``Action.STAY`` when the target is the
    source or cannot be reached.
    """
    height, width = steps.shape
    if steps[row, col] >= UNREACHABLE:
        return 4
    action = 4
    while steps[row, col] > 0:
        for k in range(4):
            rr, cc = row - MOVES[k, 0], col - MOVES[k, 1]
            if 0 <= rr < height and 0 <= cc < width and steps[rr, cc] == steps[row, col] - 1:
                row, col, action = rr, cc, k
                break
    return action
