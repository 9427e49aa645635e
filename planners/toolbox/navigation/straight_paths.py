"""Straight paths: among all shortest paths on the grid, one through the middle and not along the walls.

On a grid most goals have many shortest paths of the same length. A UAV on a path whose remainder is as diagonal as
possible sees around corners earlier than on one that follows a wall.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.grid.levels import beside, degree
from indoor_explorers.env.search.bfs import flood_nearby


@kernel(entry=False)
def _descent(steps: np.ndarray, height: int, width: int, start: int, goal: int, rise: int) -> np.ndarray:
    """Return the cells from ``start`` to ``goal``, each step reducing the longer of the two axes if it can."""
    path = np.empty(steps[start] + 1, np.int32)
    row, col = divmod(start, width)
    goal_row, goal_col = divmod(goal, width)
    path[0] = start
    for place in range(1, path.shape[0]):
        ahead, best = path.shape[0] - 1 - place, height + width
        next_row, next_col = row, col
        for k in range(degree(rise)):
            r, c = beside(row, col, k, rise)
            if 0 <= r < height and 0 <= c < width and steps[r * width + c] == ahead:
                longer = max(abs(goal_row - r), abs(goal_col - c))
                if longer < best:
                    best, next_row, next_col = longer, r, c
        row, col = next_row, next_col
        path[place] = row * width + col
    return path


@kernel()
def _straight(belief: np.ndarray, start: int, goal: int, rise: int = 0) -> np.ndarray:
    steps, queue = np.full(belief.size, UNREACHABLE, np.int32), np.empty(belief.size, np.int32)
    flood_nearby(belief, goal, start, int(UNREACHABLE), queue, steps, rise)
    if steps[start] == UNREACHABLE:
        return queue[:0]
    return _descent(steps, belief.shape[0], belief.shape[1], start, goal, rise)


def straight_path(belief: Belief, cell: Cell, goal: Cell, rise: int = 0) -> list[Cell]:
    """Return a shortest path on a (H, W) belief from ``cell`` to ``goal``, both included; empty if there is none."""
    width = belief.shape[1]
    path = _straight(belief, cell[0] * width + cell[1], goal[0] * width + goal[1], rise)
    return [divmod(place, width) for place in path.tolist()]
