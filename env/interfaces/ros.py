"""For robots that run ROS 2: occupancy grids and poses become views, actions become goals.

This module does not import ROS: a message is any object with the fields of ``nav_msgs/OccupancyGrid`` or
``geometry_msgs/PoseStamped``. ROS maps begin at the lower left, x runs along the columns and y against the rows, in
metres; maps of this package begin at the upper left.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief, Cell, Mask, read_only
from indoor_explorers.env.grid.cells import FREE, MOVES, OCCUPIED, UNKNOWN, Action
from indoor_explorers.env.policies.view import Mate, Message, View, message_numbers

#: The values of a grid for unknown, free and occupied cells, in the order of a belief's values.
OCCUPANCY = np.array([-1, 0, 100], np.int8)
#: Occupancies in percent: up to the first a cell is free, from the second on occupied, as Nav2's map server has it.
FREE_UP_TO, OCCUPIED_FROM = 25, 65
#: Log-odds of unknown, free and occupied cells on a map that may change.
LOG_ODDS = np.array([0.0, -100.0, 100.0], np.float32)
#: Kinds of a ``visualization_msgs/Marker``, and what is to become of one.
CUBE, SPHERE, LINE_STRIP, LINE_LIST, CUBE_LIST, SPHERE_LIST, TEXT = 1, 2, 4, 5, 6, 7, 9
ADD, DELETE, DELETE_ALL = 0, 2, 3
#: Tolerance, as a share of a cell, of the alignment of a grid with the cells of its frame.
NEARLY = 0.02


def quaternion_of(yaw: float) -> tuple[float, float, float, float]:
    """Return a rotation about z in radians as (x, y, z, w) of a ``geometry_msgs/Quaternion``."""
    return 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)


class Goal(NamedTuple):
    """The goal pose of a robot in the frame of its map."""

    x: float
    """Metres."""
    y: float
    """Metres."""
    yaw: float
    """Radians: the direction of the last move; 0 before the first."""

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """The yaw as (x, y, z, w) of a ``geometry_msgs/Quaternion``."""
        return quaternion_of(self.yaw)


@dataclass(frozen=True, kw_only=True)
class GridFrame:
    """The position of the cells of an (H, W) map in the ROS frame ``map``."""

    shape: tuple[int, int]
    """(H, W) in cells."""
    resolution: float = 1.0
    """Metres a cell."""
    origin: tuple[float, float] = (0.0, 0.0)
    """(x, y) of the lower left corner in metres."""

    def __post_init__(self) -> None:
        if min(self.shape) < 1 or not 0 < self.resolution < math.inf:
            raise InputError(f"expected a map of some cells and a resolution above 0, got {self}")

    def point(self, cell: Cell) -> tuple[float, float]:
        """Return (x, y) of the centre of a cell (row, column) in metres."""
        row, col = cell
        x, y = self.origin
        return x + (col + 0.5) * self.resolution, y + (self.shape[0] - row - 0.5) * self.resolution

    def cell(self, x: float, y: float) -> Cell:
        """Return the cell (row, column) of a point in metres; raise :class:`InputError` if it is off the map."""
        col = math.floor((x - self.origin[0]) / self.resolution)
        row = self.shape[0] - 1 - math.floor((y - self.origin[1]) / self.resolution)
        if not (0 <= row < self.shape[0] and 0 <= col < self.shape[1]):
            raise InputError(f"expected a point on the map, got ({x:g}, {y:g}) m; {self} ends before")
        return row, col

    def occupancy(self, belief: Belief) -> NDArray[np.int8]:
        """Return the ``data`` of an OccupancyGrid, (H * W,) int8: -1 unknown, 0 free, 100 occupied."""
        return OCCUPANCY[belief[::-1]].ravel()

    def belief(self, grid: Any) -> Belief:
        """Return the (H, W) belief of an OccupancyGrid, or of an (H, W) int8 array in its row order.

        A grid may be smaller than the frame; the other cells are unknown.

        Raises:
            InputError: it has another resolution, is turned, or has known cells outside of the frame.

        """
        values, (down, right) = self._values(grid)
        known = np.full(values.shape, UNKNOWN, np.uint8)
        known[(values >= 0) & (values <= FREE_UP_TO)] = FREE
        known[(values >= OCCUPIED_FROM) & (values <= 100)] = OCCUPIED
        belief = np.full(self.shape, UNKNOWN, np.uint8)
        rows, cols = np.nonzero(known)
        inside = (rows + down >= 0) & (rows + down < self.shape[0]) & (cols + right >= 0)
        if not (inside & (cols + right < self.shape[1])).all():
            raise InputError(f"expected a grid whose known cells are within {self}, got others; make the frame larger")
        belief[rows + down, cols + right] = known[rows, cols]
        return belief

    def _values(self, grid: Any) -> tuple[NDArray[np.int8], tuple[int, int]]:
        """Return the occupancies (h, w) of a grid, upper row first, and its upper left cell in the frame."""
        if isinstance(grid, np.ndarray):
            if grid.shape != self.shape:
                raise InputError(f"expected an array of shape {self.shape}, got {grid.shape}")
            return grid[::-1].astype(np.int8), (0, 0)
        info, corner = grid.info, grid.info.origin
        values = np.asarray(grid.data, np.int8).reshape(info.height, info.width)[::-1]
        if abs(info.resolution / self.resolution - 1) > NEARLY / max(self.shape):
            raise InputError(
                f"expected a grid of {self.resolution:g} m a cell, got {info.resolution:g}; resample one of the two"
            )
        if max(abs(corner.orientation.x), abs(corner.orientation.y), abs(corner.orientation.z)) > 1e-6:
            raise InputError("expected a grid that is not turned against its frame, got a rotation in its origin")
        right = (corner.position.x - self.origin[0]) / self.resolution
        up = (corner.position.y - self.origin[1]) / self.resolution
        if max(abs(right - round(right)), abs(up - round(up))) > NEARLY:
            raise InputError(
                f"expected an origin whole cells of {self.resolution:g} m from {self.origin}, "
                f"got ({corner.position.x:g}, {corner.position.y:g}); move the frame's origin"
            )
        return values, (self.shape[0] - round(up) - info.height, round(right))


def legal_moves(belief: Belief, cell: Cell) -> Mask:
    """Return (5,) bool: actions that end in a known free cell; staying is always legal."""
    legal = np.zeros(len(MOVES), np.bool_)
    for action, (row, col) in enumerate((MOVES + np.array(cell)).tolist()):
        inside = 0 <= row < belief.shape[0] and 0 <= col < belief.shape[1]
        legal[action] = inside and belief[row, col] == FREE
    legal[Action.STAY] = True
    return legal


class Robot:
    """Convert between the topics of one robot of a team and its pilot.

    In each step call :meth:`hear` for each teammate in contact, :meth:`view`, the pilot's ``act``, and :meth:`goal`.
    The next step begins when the goal is reached or given up.
    """

    def __init__(self, frame: GridFrame, *, budget: int) -> None:
        """Start an episode of ``budget`` steps on the map of a frame."""
        self.frame, self.budget = frame, budget
        self._step, self._yaw = 0, 0.0
        self._cell: Cell | None = None
        self._visited = np.zeros(frame.shape, np.bool_)
        self._belief = np.full(frame.shape, UNKNOWN, np.uint8)
        self._corrected = False
        self._heard: dict[int, tuple[Cell, int, Message]] = {}

    def hear(self, agent: int, pose: Any, message: Message = None) -> None:
        """Store a teammate's pose, see :meth:`view`, and its last message, before the view of this step."""
        self._heard[agent] = self.frame.cell(*_point(pose)), self._step, message_numbers(message)

    def view(self, grid: Any, pose: Any) -> View:
        """Return the view of this step; it has log-odds once a known cell has changed, so that pilots plan again.

        Args:
            grid: The robot's own map, an OccupancyGrid or an (H, W) int8 array in its row order.
            pose: The robot's pose, a PoseStamped, a Pose, or (x, y) in metres.

        Raises:
            InputError: the grid or the pose does not fit the frame.

        """
        belief, self._cell = self.frame.belief(grid), self.frame.cell(*_point(pose))
        belief[self._cell] = FREE  # the robot occupies it
        self._corrected |= bool(((self._belief != UNKNOWN) & (self._belief != belief)).any())
        self._belief = read_only(belief)
        self._visited[self._cell] = True
        mates = tuple(
            Mate(agent, cell, self._step - step, message)
            for agent, (cell, step, message) in sorted(self._heard.items())
        )
        step, self._step = self._step, self._step + 1
        legal = legal_moves(belief, self._cell)
        return View(
            *(self._belief, self._cell, read_only(legal), step, self.budget, mates),
            visited=read_only(self._visited),
            log_odds=LOG_ODDS[belief] if self._corrected else None,
        )

    def goal(self, action: int) -> Goal:
        """Return the centre of the cell that an action leads to from the cell of the last view.

        Raises:
            InputError: the action leads off the map, or there was no view yet.

        """
        if self._cell is None:
            raise InputError("expected a view before the first goal, got none")
        down, right = MOVES[action].tolist()
        if down or right:
            self._yaw = math.atan2(-down, right)
        x, y = self.frame.point((self._cell[0] + down, self._cell[1] + right))
        self.frame.cell(x, y)
        return Goal(x, y, self._yaw)


def _point(pose: Any) -> tuple[float, float]:
    """Return (x, y) of a PoseStamped, a Pose, or a pair of numbers."""
    inner = getattr(pose, "pose", pose)
    if hasattr(inner, "position"):
        return float(inner.position.x), float(inner.position.y)
    x, y = inner
    return float(x), float(y)
