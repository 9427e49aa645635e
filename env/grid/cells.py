"""The grid: cell values and moves.

Cells are (row, column). A belief map is ``(H, W) uint8`` with the values below; a true map uses the same
values without ``UNKNOWN``.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

UNKNOWN, FREE, OCCUPIED = np.uint8(0), np.uint8(1), np.uint8(2)
#: Distance, in steps, of a cell that cannot be reached.
UNREACHABLE = np.int32(2**30)


class Action(IntEnum):
    """The five actions of a UAV, numbered as in the thesis (Table 3.2)."""

    DOWN = 0
    LEFT = 1
    UP = 2
    RIGHT = 3
    STAY = 4


#: The sixth action where the lidar's field of view is limited: turn clockwise by 90 degrees in the same cell.
TURN = 5


#: (5, 2) row and column change of each action; none to turn.
MOVES = np.array([(1, 0), (0, -1), (-1, 0), (0, 1), (0, 0)], dtype=np.int64)
