"""Maps of several levels: how a volume of cells lies in a plane.

A volume (L, H, W) has L levels of H rows and W columns. Everything here works on its plane, in which the levels lie one
below the other with a row of obstacles between: (L (H + 1) - 1, W). Moves, searches and frontiers on one level then
are those of a plain map, and the cell one level up is ``rise`` = H + 1 rows further down in the plane. A map of one
level is its own plane, and its rise is 0.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Mask
from indoor_explorers.env.grid.cells import MOVES, OCCUPIED, Action
from indoor_explorers.env.grid.compiled import inner, leaf

#: The actions that only UAVs on maps of several levels have: move one level up, or down.
ASCEND, DESCEND = 5, 6
#: (level, row, column).
Voxel = tuple[int, int, int]

_ACTIONS = {(int(row), int(col)): action for action, (row, col) in enumerate(MOVES)}


class Levels(NamedTuple):
    """The size of a volume, and what is where in its plane."""

    number: int
    """L, the number of levels, 1 or more."""
    height: int
    """H, rows of a level."""
    width: int
    """W, columns."""

    @classmethod
    def of(cls, shape: tuple[int, ...], count: int) -> Levels:
        """Return the levels of a plane of a ``shape`` (rows, columns).

        Raises:
            ValueError: ``count`` levels of equal height do not make a plane of so many rows.

        """
        if count < 1 or (shape[0] + 1) % count != 0 or shape[0] + 1 < 2 * count:
            raise ValueError(f"expected a plane of {count} levels of equal height, got {shape[0]} rows")
        return cls(count, (shape[0] + 1) // count - 1, shape[1])

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the plane."""
        return self.number * (self.height + 1) - 1, self.width

    @property
    def rise(self) -> int:
        """Rows of the plane from a cell to the one a level higher; 0 where there is one level."""
        return self.height + 1 if self.number > 1 else 0

    @property
    def moves(self) -> int:
        """Actions that are moves or stay: 5, or 7 with those up and down."""
        return 7 if self.number > 1 else 5

    def cell(self, voxel: Voxel) -> Cell:
        """Return where (level, row, column) is in the plane."""
        level, row, col = voxel
        return level * (self.height + 1) + row, col

    def voxel(self, cell: Cell) -> Voxel:
        """Return the (level, row, column) of a cell of the plane."""
        level, row = divmod(int(cell[0]), self.height + 1)
        return level, row, int(cell[1])

    @property
    def size(self) -> tuple[int, ...]:
        """(L, H, W), or (H, W) where there is one level."""
        return tuple(self) if self.number > 1 else (self.height, self.width)

    def voxels(self, cells: NDArray[Any]) -> NDArray[Any]:
        """Return the (level, row, column) (..., 3) of cells (..., 2) of the plane."""
        rows = cells[..., 0]
        level = rows // (self.height + 1) if self.number > 1 else np.zeros_like(rows)
        return np.stack((level, rows - level * (self.height + 1), cells[..., 1]), axis=-1)

    def volume(self, plane: NDArray[Any], *, writeable: bool = False) -> NDArray[Any]:
        """Return an array of the plane's shape as (L, H, W), without a copy and, unless ``writeable``, read-only."""
        along, across = plane.strides
        return as_strided(plane, tuple(self), (along * (self.height + 1), along, across), writeable=writeable)

    @property
    def between(self) -> Mask:
        """Mask of the rows of obstacles between the levels, in the plane."""
        mask = np.zeros(self.shape, np.bool_)
        mask[self.height :: self.height + 1] = True
        return mask


def plane_of(volume: NDArray[Any], between: Any = OCCUPIED) -> NDArray[Any]:
    """Return the plane of a volume (L, H, W), with rows of one value ``between`` its levels."""
    levels = Levels(*volume.shape)
    plane = np.full((levels.number, levels.height + 1, levels.width), between, volume.dtype)
    plane[:, :-1] = volume
    return plane.reshape(-1, levels.width)[:-1]


@leaf()
def rise_of(rows: int, count: int) -> int:
    """Return the rise of a plane of so many ``rows`` that holds ``count`` levels; 0 where there is one."""
    return (rows + 1) // count if count > 1 else 0


@inner()
def on_level(row: int, rise: int) -> tuple[int, int]:
    """Return the level of a row of the plane, 0 where there is one, and the row on that level."""
    return (row // rise, row % rise) if rise > 0 else (0, row)


@leaf()
def offset(row: int, col: int, to_row: int, to_col: int, rise: int) -> tuple[int, int, int]:
    """Return how many levels, rows and columns lead from one cell of the plane to another."""
    if rise == 0:
        return 0, to_row - row, to_col - col
    return to_row // rise - row // rise, to_row % rise - row % rise, to_col - col


def coordinates(cells: NDArray[np.integer[Any]], width: int, rise: int) -> NDArray[np.int64]:
    """Return the rows and columns (..., 2) of flat cells (...) of the plane, or levels, rows and columns (..., 3)."""
    rows, cols = np.divmod(cells, width)
    return np.stack((*np.divmod(rows, rise), cols) if rise > 0 else (rows, cols), axis=-1)


@inner()
def enter_between(belief: np.ndarray, count: int) -> None:
    """Enter the rows of obstacles between ``count`` levels into a plane (H, W) uint8."""
    rise = rise_of(belief.shape[0], count)
    for level in range(1, count):
        belief[level * rise - 1, :] = OCCUPIED


@inner()
def degree(rise: int) -> int:
    """Return how many neighbours a cell has: 4, or 6 where there are levels."""
    return 6 if rise > 0 else 4


@inner()
def beside(row: int, col: int, k: int, rise: int) -> tuple[int, int]:
    """Return neighbour ``k`` of a cell of the plane, in the order of the actions; it may be off the map.

    ``k`` is 0 to 3 for those of the same level, 4 and 5 for those above and below.
    """
    if k < 4:
        return row + MOVES[k, 0], col + MOVES[k, 1]
    return (row + rise if k == 4 else row - rise), col


def action_names(count: int) -> list[str]:
    """Return the names of the actions of a UAV that has so many: 5, 6 with turns, 7 where there are levels."""
    return [action.name.lower() for action in Action] + {5: [], 6: ["turn"], 7: ["ascend", "descend"]}[count]


def target_of(cell: Cell, action: int, rise: int = 0) -> Cell:
    """Return the cell of the plane that an action leads to; it may be off the map."""
    if action in (ASCEND, DESCEND):
        return cell[0] + (rise if action == ASCEND else -rise), cell[1]
    return cell[0] + int(MOVES[action, 0]), cell[1] + int(MOVES[action, 1])


def action_between(cell: Cell, following: Cell, rise: int = 0) -> int:
    """Return the action that leads from a cell to the same or an adjacent one."""
    along, across = following[0] - cell[0], following[1] - cell[1]
    if across == 0 and rise > 0 and abs(along) == rise:
        return ASCEND if along > 0 else DESCEND
    return _ACTIONS[along, across]
