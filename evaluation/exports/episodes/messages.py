"""ROS 2 messages of an episode: grids, poses, paths, scans, markers and frames.

The types come from rosbags and follow the message definitions of ROS, which are the same from ROS 2
Humble to Lyrical.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_typestore

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.interfaces import GridFrame

STORE = get_typestore(Stores.ROS2_HUMBLE)
#: The frame of the maps.
MAP = "map"
#: Kinds of markers, and what becomes of one, as ``visualization_msgs/Marker`` numbers them.
LINE_LIST, CUBE_LIST, ADD, DELETE = 5, 6, 0, 2
NANOSECONDS = 1_000_000_000


def uav_frame(uav: int) -> str:
    """Return the name of a UAV's frame, and of its topics' namespace."""
    return f"uav_{uav}"


class Messages:
    """Make the messages of one moment, ``stamp`` nanoseconds after time 0."""

    def __init__(self, frame: GridFrame, stamp: int) -> None:
        self.frame, self.stamp = frame, stamp

    def grid(self, belief: Belief) -> Any:
        """Return a ``nav_msgs/OccupancyGrid``."""
        height, width = belief.shape
        origin = _new("geometry_msgs/msg/Pose", _point(*self.frame.origin), _upright())
        info = _new("nav_msgs/msg/MapMetaData", self._time(), self.frame.resolution, width, height, origin)
        return _new("nav_msgs/msg/OccupancyGrid", self._header(), info, self.frame.occupancy(belief))

    def pose(self, cell: Sequence[int]) -> Any:
        """Return a ``geometry_msgs/PoseStamped``; UAVs do not turn."""
        pose = _new("geometry_msgs/msg/Pose", self._centre(cell), _upright())
        return _new("geometry_msgs/msg/PoseStamped", self._header(), pose)

    def path(self, poses: Sequence[Any]) -> Any:
        """Return a ``nav_msgs/Path`` of some stamped poses."""
        return _new("nav_msgs/msg/Path", self._header(), list(poses))

    def scan(self, uav: int, ranges: NDArray[np.floating], lidar_range: float, seconds: float) -> Any:
        """Return a ``sensor_msgs/LaserScan`` of (K,) ranges in cells, the first of them opposite to x."""
        turn = 2 * math.pi / len(ranges)
        metres = (ranges * self.frame.resolution).astype(np.float32)
        return _new(
            *("sensor_msgs/msg/LaserScan", self._header(uav_frame(uav)), -math.pi, math.pi - turn, turn, 0.0, seconds),
            *(0.0, lidar_range * self.frame.resolution, metres, np.empty(0, np.float32)),
        )

    def markers(self, name: str, kind: int, cells: NDArray[np.integer], colour: NDArray[np.uint8]) -> Any:
        """Return a ``visualization_msgs/MarkerArray`` of one list of points in the centres of (K, 2) cells.

        No points delete the marker, which must not be empty.
        """
        size = self.frame.resolution * (0.12 if kind == LINE_LIST else 0.9)
        marker = _new(
            *("visualization_msgs/msg/Marker", self._header(), name, 0, kind, ADD if len(cells) else DELETE),
            _new("geometry_msgs/msg/Pose", _point(0.0, 0.0), _upright()),
            _new("geometry_msgs/msg/Vector3", size, size, 0.1 * size),
            _new("std_msgs/msg/ColorRGBA", *(colour / 255).tolist(), 0.7),
            _new("builtin_interfaces/msg/Duration", 0, 0),
            *(False, [self._centre(cell) for cell in cells.tolist()], [], ""),
            _new("sensor_msgs/msg/CompressedImage", self._header(""), "", np.empty(0, np.uint8)),
            *([], "", "", _new("visualization_msgs/msg/MeshFile", "", np.empty(0, np.uint8)), False),
        )
        return _new("visualization_msgs/msg/MarkerArray", [marker])

    def frames(self, cells: dict[int, Sequence[int]]) -> Any:
        """Return a ``tf2_msgs/TFMessage`` with the frame of each UAV in ``cells``."""
        transforms = []
        for uav, cell in cells.items():
            place = _new("geometry_msgs/msg/Vector3", *self.frame.point((cell[0], cell[1])), 0.0)
            moved = _new("geometry_msgs/msg/Transform", place, _upright())
            transforms.append(
                _new("geometry_msgs/msg/TransformStamped", self._header(), uav_frame(uav), moved),
            )
        return _new("tf2_msgs/msg/TFMessage", transforms)

    def number(self, value: float) -> Any:
        """Return a ``std_msgs/Float64``."""
        return _new("std_msgs/msg/Float64", value)

    def _centre(self, cell: Sequence[int]) -> Any:
        return _point(*self.frame.point((cell[0], cell[1])))

    def _header(self, frame: str = MAP) -> Any:
        return _new("std_msgs/msg/Header", self._time(), frame)

    def _time(self) -> Any:
        return _new("builtin_interfaces/msg/Time", *divmod(self.stamp, NANOSECONDS))


def _new(kind: str, *fields: Any) -> Any:
    return STORE.types[kind](*fields)


def _point(x: float, y: float) -> Any:
    return _new("geometry_msgs/msg/Point", x, y, 0.0)


def _upright() -> Any:
    return _new("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)
