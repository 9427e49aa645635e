"""Moves along shortest paths that show a sensor with a limited field of view most of the unknown.

A UAV faces the direction of its last move. On a grid there are many shortest paths to a goal, and each of their moves
shows another part of the map. So a UAV can look around without flying farther.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import MOVES, UNKNOWN
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.sensing.field_of_view import is_in_view, least_cosine
from indoor_explorers.env.sensing.lidar import LidarModel, Scan, lidar_model, new_scan, visible_cells
from indoor_explorers.planners.toolbox.navigation.paths import Paths


@leaf()
def unknown_ahead(
    belief: np.ndarray, row: int, col: int, move: int, lidar: LidarModel, scan: Scan, cosine: float
) -> int:
    """Count the unknown cells of a (H, W) belief that are in view from a cell by a sensor that faces a move.

    Unknown cells are transparent. ``cosine`` is the :func:`~indoor_explorers.env.sensing.field_of_view.least_cosine`.
    """
    width, seen = belief.shape[1], 0
    for place in range(visible_cells(belief, row, col, lidar, scan)):
        r, c = divmod(scan.cells[place], width)
        if belief[r, c] == UNKNOWN:
            seen += is_in_view(cosine, move, r - row, c - col)
    return seen


@kernel()
def move_gains(
    belief: np.ndarray, row: int, col: int, moves: np.ndarray, lidar: LidarModel, cosine: float
) -> np.ndarray:
    """Return the :func:`unknown_ahead` after each of (K,) moves from a cell, (K,) int64."""
    scan = new_scan(lidar)
    gains = np.zeros(moves.shape[0], np.int64)
    for k in range(moves.shape[0]):
        down, right = MOVES[moves[k], 0], MOVES[moves[k], 1]
        gains[k] = unknown_ahead(belief, row + down, col + right, moves[k], lidar, scan, cosine)
    return gains


class CameraMoves:
    """Choose the moves of one UAV along shortest paths by what its sensor sees after them."""

    def __init__(self, briefing: Briefing) -> None:
        self._lidar = lidar_model(float(briefing.lidar_range))
        self._cosine = least_cosine(briefing.scenario.lidar.field_of_view)
        self._paths = Paths(briefing.shape)
        self._field: tuple[Cell, int, NDArray[np.int32]] | None = None

    def next_cell(self, view: View, path: list[Cell], stamp: int) -> Cell:
        """Return the cell to fly to next on a shortest path to the end of ``path``, which begins at the UAV's cell.

        It is the one with the largest gain, and among equals that of ``path``. A path that is no shortest one, such
        as a detour around a teammate, is followed as it is. ``stamp`` is the map's :func:`~.paths.map_stamp`.
        """
        steps = self._steps_to(view, path[-1], stamp)
        if steps[view.cell] != len(path) - 1:
            return path[1]
        row, col = view.cell
        taken = {mate.cell for mate in view.mates if mate.age == 0}
        moves = [
            (move, cell)
            for move, (down, right) in enumerate(MOVES[:4].tolist())
            if view.legal[move] and steps[cell := (row + down, col + right)] < steps[view.cell] and cell not in taken
        ]
        if len(moves) < 2:
            return path[1]
        gains = move_gains(view.belief, row, col, np.array([move for move, _ in moves]), self._lidar, self._cosine)
        ranked = [(int(gain), cell == path[1], cell) for gain, (_, cell) in zip(gains, moves, strict=True)]
        return max(ranked)[2]

    def _steps_to(self, view: View, goal: Cell, stamp: int) -> NDArray[np.int32]:
        """Return the (H, W) steps to a goal through known free cells; kept while neither goal nor map change."""
        if self._field is None or self._field[:2] != (goal, stamp):
            self._field = goal, stamp, self._paths.field(view.belief, goal)
        return self._field[2]
