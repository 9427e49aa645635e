"""Explore with one robot beside a ROS 2 system, over DDS."""

from __future__ import annotations

import math
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from indoor_explorers.env import Policy
from indoor_explorers.env.interfaces.ros import ADD, DELETE
from indoor_explorers.evaluation.robot.dds import Node, quality, taken
from indoor_explorers.evaluation.robot.drawings import Drawing, drawings
from indoor_explorers.evaluation.robot.explorer import Explorer, State
from indoor_explorers.evaluation.robot.messages import new, point, turned
from indoor_explorers.evaluation.robot.navigation import GoalAction, GoalTopic, Pose, pose_stamped
from indoor_explorers.evaluation.robot.occupancy import yaw_of
from indoor_explorers.evaluation.robot.settings import RobotSettings

#: Seconds between two ticks, and between two publications of what changes slowly.
TICK, TELL = 0.1, 1.0


@dataclass(frozen=True, kw_only=True)
class Wiring:
    """The names of a robot's topics and frames."""

    action: bool = False
    """Whether goals go by the action ``navigate_to_pose`` instead of the topic ``goal_pose``."""
    map_topic: str = "map"
    """Relative to the robot's namespace, unless it begins with a slash."""
    map_frame: str = "map"
    base_frame: str = "base_link"


class Frames:
    """The tree of frames of a robot; rotations about other axes than z are left out."""

    def __init__(self, node: Node) -> None:
        kind = "tf2_msgs/msg/TFMessage"
        self._moving = node.reader(kind, "tf", quality(100, reliable=False))
        self._fixed = node.reader(kind, "tf_static", quality(100, latched=True))
        self._parents: dict[str, tuple[str, Pose]] = {}

    def hear(self) -> bool:
        """Read what has arrived; return whether a frame that moves was among it."""
        moving = taken(self._moving, 200)
        for message in [*taken(self._fixed, 200), *moving]:
            for each in message.transforms:
                place, turn = each.transform.translation, each.transform.rotation
                self._parents[each.child_frame_id.lstrip("/")] = (
                    each.header.frame_id.lstrip("/"),
                    (place.x, place.y, yaw_of(turn)),
                )
        return bool(moving)

    def pose(self, frame: str, child: str) -> Pose | None:
        """Return (x, y, yaw) of a frame in another one; None while they are not connected."""
        x = y = yaw = 0.0
        for _ in range(len(self._parents) + 1):
            if child == frame:
                return x, y, yaw
            if child not in self._parents:
                return None
            child, (dx, dy, turn) = self._parents[child]
            cos, sin = math.cos(turn), math.sin(turn)
            x, y, yaw = dx + cos * x - sin * y, dy + sin * x + cos * y, yaw + turn
        return None


class Link:
    """Connect the explorer of one robot with the topics of its ROS 2 system."""

    def __init__(self, explorer: Explorer, wiring: Wiring) -> None:
        settings = explorer.settings
        self._explorer, self._wiring, node = explorer, wiring, Node(settings.name)
        self._map = node.reader("nav_msgs/msg/OccupancyGrid", wiring.map_topic, quality(1, latched=True))
        self._resume = node.reader("std_msgs/msg/Bool", "explore/resume", quality(10))
        self._frames = Frames(node)
        self._navigation = (GoalAction if wiring.action else GoalTopic)(node, wiring.map_frame)
        self._pose = node.writer("geometry_msgs/msg/PoseStamped", "explore/pose", quality(1))
        self._message = node.writer("std_msgs/msg/Float64MultiArray", "explore/message", quality(1))
        self._markers = node.writer("visualization_msgs/msg/MarkerArray", "explore/frontiers", quality(1, latched=True))
        self._status = node.writer("std_msgs/msg/String", "explore/status", quality(1, latched=True))
        self._mates = {
            mate: (
                node.reader("geometry_msgs/msg/PoseStamped", f"/{mate}/explore/pose", quality(1)),
                node.reader("std_msgs/msg/Float64MultiArray", f"/{mate}/explore/message", quality(1)),
            )
            for mate in settings.robots
            if mate != settings.name
        }
        self._said: dict[str, tuple[float, ...]] = {}
        self._told, self._told_at = "", -math.inf

    def step(self, now: float) -> None:
        """Hear, tick and tell."""
        self._hear(now)
        command = self._explorer.tick(now)
        if command is not None and command.goal is not None:
            self._navigation.send(command.goal)
        elif command is not None:
            self.stop()
        self._tell(now)

    def stop(self) -> None:
        """Make the robot give up its goal."""
        self._navigation.stop(self._explorer.pose)

    def _hear(self, now: float) -> None:
        explorer = self._explorer
        for switch in taken(self._resume):
            explorer.running = switch.data
        if self._frames.hear() and (pose := self._frames.pose(self._wiring.map_frame, self._wiring.base_frame)):
            explorer.hear_pose(*pose, now)
        for grid in taken(self._map)[-1:]:
            if grid.info.width and grid.info.height:
                explorer.hear_map(grid, now)
        for mate, (poses, messages) in self._mates.items():
            for message in taken(messages):
                self._said[mate] = tuple(message.data)
            for heard in taken(poses)[-1:]:
                place = heard.pose.position
                explorer.hear_mate(mate, place.x, place.y, self._said.get(mate) or None, now)
        reached = self._navigation.outcome(explorer.pose)
        if reached is not None:
            explorer.goal_ended(reached, now)

    def _tell(self, now: float) -> None:
        explorer = self._explorer
        if explorer.status != self._told:
            self._told = explorer.status
            self._status.write(new("std_msgs/msg/String", data=self._told))
        if now - self._told_at < TELL:
            return
        self._told_at = now
        if explorer.pose is not None:
            self._pose.write(pose_stamped(self._wiring.map_frame, *explorer.pose))
        message = explorer.piloting.message if explorer.piloting is not None else None
        self._message.write(new("std_msgs/msg/Float64MultiArray", data=[float(part) for part in message or ()]))
        markers = [_marker(self._wiring.map_frame, k, each) for k, each in enumerate(drawings(explorer))]
        self._markers.write(new("visualization_msgs/msg/MarkerArray", markers=markers))


def _marker(frame: str, number: int, drawing: Drawing) -> Any:
    size = 0.1 if not drawing.size else drawing.size
    return new(
        "visualization_msgs/msg/Marker",
        header=new("std_msgs/msg/Header", frame_id=frame),
        ns=drawing.name,
        id=number,
        type=drawing.kind,
        action=ADD if drawing.points else DELETE,
        pose=new("geometry_msgs/msg/Pose", orientation=turned(0.0)),
        scale=new("geometry_msgs/msg/Vector3", x=size, y=size, z=size),
        points=[point(x, y) for x, y in drawing.points],
        colors=[new("std_msgs/msg/ColorRGBA", r=r, g=g, b=b, a=a) for r, g, b, a in drawing.colours],
    )


def explore(
    policy: Policy, settings: RobotSettings, wiring: Wiring, say: Callable[[str], None], *, stay: bool = False
) -> None:
    """Explore until no frontier is left, or with ``stay`` until interrupted; ``say`` gets a line for each new state."""
    explorer = Explorer(policy, settings)
    link = Link(explorer, wiring)
    said, interrupted = "", False

    def interrupt(*_: object) -> None:
        nonlocal interrupted
        interrupted = True
        raise KeyboardInterrupt

    before = {number: signal.signal(number, interrupt) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        while stay or explorer.state is not State.DONE:
            if interrupted:  # what is raised in a callback of a library is lost
                raise KeyboardInterrupt
            link.step(time.monotonic())
            if explorer.status != said:
                said = explorer.status
                say(said)
            time.sleep(TICK)
        time.sleep(TELL)  # for those who read the last state
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if explorer.target is not None:
            link.stop()
            time.sleep(TICK)
