"""ROS 2 messages of an episode: grids, poses, paths, scans, markers and frames.

The types come from rosbags and follow the message definitions of ROS, which are the same from ROS 2
Humble to Lyrical.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_typestore

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import OCCUPIED
from indoor_explorers.env.interfaces.ros import ADD, CUBE, DELETE, DELETE_ALL, LINE_LIST, LINE_STRIP, SPHERE, TEXT
from indoor_explorers.env.policies.explanation import Candidate, Explanation, sentence
from indoor_explorers.env.rendering.palette import INK
from indoor_explorers.evaluation.exports.episodes.moments import MapFrame

STORE = get_typestore(Stores.ROS2_HUMBLE)
#: The frame of the maps.
MAP = "map"
NANOSECONDS = 1_000_000_000
#: RGB of the candidates of the lowest and of the highest score.
LOW, HIGH = (68, 1, 84), (253, 231, 37)


def uav_frame(uav: int) -> str:
    """Return the name of a UAV's frame, and of its topics' namespace."""
    return f"uav_{uav}"


class Messages:
    """Make the messages of one moment, ``stamp`` nanoseconds after time 0."""

    def __init__(self, frame: MapFrame, stamp: int) -> None:
        self.frame, self.stamp = frame, stamp

    def map(self, belief: Belief) -> Any:
        """Return a :meth:`grid`, or a :meth:`cloud` of a map of several levels."""
        return self.grid(belief) if self.frame.levels.number == 1 else self.cloud(belief)

    def cloud(self, belief: Belief) -> Any:
        """Return a ``sensor_msgs/PointCloud2`` of the centres of the obstacles on all levels."""
        cells = np.argwhere((belief == OCCUPIED) & ~self.frame.levels.between)
        points = self.frame.places(cells).astype("<f4")
        field, single = "sensor_msgs/msg/PointField", 7  # FLOAT32
        fields = [_new(field, name, 4 * place, single, 1) for place, name in enumerate("xyz")]
        return _new(
            *("sensor_msgs/msg/PointCloud2", self._header(), 1, len(points), fields, False, 12, 12 * len(points)),
            *(np.frombuffer(points.tobytes(), np.uint8), True),
        )

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
        action, points = ADD if len(cells) else DELETE, [_point(*place) for place in self.frame.places(cells).tolist()]
        marker = self.marker(name, 0, kind, action, _point(0.0, 0.0), (size, size, 0.1 * size), colour, 0.7, points)
        return _new("visualization_msgs/msg/MarkerArray", [marker])

    def explanation(self, told: Explanation | None, colour: NDArray[np.uint8]) -> Any:
        """Return a ``visualization_msgs/MarkerArray`` that replaces all earlier markers of its topic.

        It has the way as a line and the goal as a cube in ``colour`` (3,), a sphere for each candidate, from violet for
        the lowest score to yellow for the highest, and above them texts.
        """
        made = [self.marker("", 0, CUBE, DELETE_ALL, _point(0.0, 0.0), (0.0, 0.0, 0.0), colour)]
        size = self.frame.resolution
        if told is not None:
            if len(told.path) > 1:
                points, line = [self._centre(cell) for cell in told.path], (0.2 * size, 0.0, 0.0)
                made.append(self.marker("way", 0, LINE_STRIP, ADD, _point(0.0, 0.0), line, colour, 0.9, points))
            if told.goal is not None:
                flat = (0.9 * size, 0.9 * size, 0.1 * size)
                made.append(self.marker("goal", 0, CUBE, ADD, self._centre(told.goal), flat, colour, 0.6))
                place = self._centre(told.goal, 1.2 * size)
                made.append(self._text("goal text", 0, place, sentence(told, self.frame.levels)))
            made += self._candidates(told.candidates)
        return _new("visualization_msgs/msg/MarkerArray", made)

    def _candidates(self, candidates: Sequence[Candidate]) -> Iterator[Any]:
        size, scores = 0.6 * self.frame.resolution, np.array([each.score for each in candidates])
        shares = (scores - scores.min(initial=np.inf)) / max(np.ptp(scores) if len(scores) else 0.0, 1e-12)
        for rank, (each, share) in enumerate(zip(candidates, shares.tolist(), strict=True), 1):
            shade = np.rint(np.array(LOW) + share * (np.array(HIGH) - LOW)).astype(np.uint8)
            yield self.marker("candidates", rank, SPHERE, ADD, self._centre(each.cell), (size, size, size), shade)
            place = self._centre(each.cell, size)
            yield self._text("scores", rank, place, f"{rank}: {each.score:.3g}")

    def _text(self, name: str, number: int, place: Any, text: str) -> Any:
        """Return a text marker with letters 0.5 cells high."""
        ink = np.array(INK, np.uint8)
        return self.marker(name, number, TEXT, ADD, place, (0.0, 0.0, 0.5 * self.frame.resolution), ink, text=text)

    def marker(
        self,
        name: str,
        number: int,
        kind: int,
        action: int,
        place: Any,
        size: tuple[float, float, float],
        colour: NDArray[np.uint8],
        alpha: float = 1.0,
        points: Sequence[Any] = (),
        text: str = "",
    ) -> Any:
        """Return a ``visualization_msgs/Marker`` of a namespace ``name``, at a ``geometry_msgs/Point``."""
        return _new(
            *("visualization_msgs/msg/Marker", self._header(), name, number, kind, action),
            _new("geometry_msgs/msg/Pose", place, _upright()),
            _new("geometry_msgs/msg/Vector3", *size),
            _new("std_msgs/msg/ColorRGBA", *(colour / 255).tolist(), alpha),
            _new("builtin_interfaces/msg/Duration", 0, 0),
            *(False, list(points), [], ""),
            _new("sensor_msgs/msg/CompressedImage", self._header(""), "", np.empty(0, np.uint8)),
            *([], text, "", _new("visualization_msgs/msg/MeshFile", "", np.empty(0, np.uint8)), False),
        )

    def frames(self, cells: dict[int, Sequence[int]]) -> Any:
        """Return a ``tf2_msgs/TFMessage`` with the frame of each UAV in ``cells``."""
        transforms = []
        for uav, cell in cells.items():
            place = _new("geometry_msgs/msg/Vector3", *self.frame.place(cell))
            moved = _new("geometry_msgs/msg/Transform", place, _upright())
            transforms.append(
                _new("geometry_msgs/msg/TransformStamped", self._header(), uav_frame(uav), moved),
            )
        return _new("tf2_msgs/msg/TFMessage", transforms)

    def number(self, value: float) -> Any:
        """Return a ``std_msgs/Float64``."""
        return _new("std_msgs/msg/Float64", value)

    def _centre(self, cell: Sequence[int], height: float = 0.0) -> Any:
        x, y, z = self.frame.place(cell)
        return _point(x, y, z + height)

    def _header(self, frame: str = MAP) -> Any:
        return _new("std_msgs/msg/Header", self._time(), frame)

    def _time(self) -> Any:
        return _new("builtin_interfaces/msg/Time", *divmod(self.stamp, NANOSECONDS))


def _new(kind: str, *fields: Any) -> Any:
    return STORE.types[kind](*fields)


def _point(x: float, y: float, z: float = 0.0) -> Any:
    return _new("geometry_msgs/msg/Point", x, y, z)


def _upright() -> Any:
    return _new("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)
