"""What a robot can reach on a belief: frontiers, the nearest of them, and the cell that it counts to be in."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.search.frontiers import frontier_mask, on_frontier


def is_frontier(belief: Belief, cell: Cell) -> bool:
    """Tell whether a cell of a (H, W) belief is free and beside an unknown one."""
    return bool(on_frontier(belief, cell[0] * belief.shape[1] + cell[1]))


def nearest_frontier(belief: Belief, cell: Cell) -> Cell | None:
    """Return the frontier cell with the shortest way from a cell, which may hold any value; None if there is none."""
    steps = np.where(frontier_mask(belief), distance_field(belief, cell), UNREACHABLE)
    row, col = divmod(int(steps.argmin()), belief.shape[1])
    return None if steps[row, col] >= UNREACHABLE else (row, col)


def standing(belief: Belief, own: Cell, reach: float) -> tuple[Cell, Cell | None]:
    """Return the free cell nearest to a robot's own, at most ``reach`` cells away, that has a frontier in reach.

    Without one it is the nearest free cell, or the robot's own, which then counts as free. Robots stand beside walls,
    where no cell is free. The second cell is the frontier nearest to it, None if there is none.
    """
    near = np.argwhere(belief == FREE)
    away = np.hypot(*(near - own).T)
    order = np.argsort(away, kind="stable")[: int((away <= reach).sum())]
    if not len(order):
        belief[own] = FREE
        return own, nearest_frontier(belief, own)
    cells = [(int(row), int(col)) for row, col in near[order].tolist()]
    found = ((cell, nearest) for cell in cells if (nearest := nearest_frontier(belief, cell)) is not None)
    return next(found, (cells[0], None))
