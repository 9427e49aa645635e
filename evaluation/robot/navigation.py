"""Goals for Nav2 over DDS: on the topic ``goal_pose``, or by the action ``navigate_to_pose``.

Both read the states of goals from the topic ``navigate_to_pose/_action/status``. The action needs
``rmw_cyclonedds_cpp`` on the robot: services of other middlewares have other headers.
"""

from __future__ import annotations

import math
import secrets
import time
from abc import ABC, abstractmethod
from typing import Any

from indoor_explorers.env.interfaces.ros import Goal
from indoor_explorers.evaluation.robot.dds import Client, Node, quality, taken
from indoor_explorers.evaluation.robot.messages import new, point, turned, uuid

ACTION = "navigate_to_pose/_action/"
#: States of a goal, as ``action_msgs/GoalStatus`` numbers them.
ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(1, 7)
#: Metres from a goal within which it counts as reached where nothing says how the goal has ended.
TOLERANCE = 0.3
#: Seconds after a goal on the topic in which states may still be those of the goal before.
SETTLED = 1.0

Pose = tuple[float, float, float]


def pose_stamped(frame: str, x: float, y: float, yaw: float) -> Any:
    """Return a ``geometry_msgs/PoseStamped``; its time is 0, for the latest transform in real and simulated time."""
    pose = new("geometry_msgs/msg/Pose", position=point(x, y), orientation=turned(yaw))
    return new("geometry_msgs/msg/PoseStamped", header=new("std_msgs/msg/Header", frame_id=frame), pose=pose)


class Navigation(ABC):
    """Send goals to the navigation of one robot and learn how they end."""

    def __init__(self, node: Node, frame: str) -> None:
        self._frame = frame
        self._status = node.reader("action_msgs/msg/GoalStatusArray", f"{ACTION}status", quality(1, latched=True))
        self._states: dict[bytes, tuple[int, int]] = {}
        """The time in ns at which each goal was accepted, and its state."""
        self._goal: Goal | None = None

    @abstractmethod
    def send(self, goal: Goal) -> None:
        """Send a goal, which replaces the last one."""

    @abstractmethod
    def stop(self, pose: Pose | None) -> None:
        """Make the robot, which is at a pose, give up its goal."""

    @abstractmethod
    def _state(self, near: bool) -> int:
        """Return the state of the last goal, to which the robot is ``near`` or not."""

    def outcome(self, pose: Pose | None) -> bool | None:
        """Return whether the last goal was reached, once; None before its end and after it was told."""
        for array in taken(self._status):
            self._states = {
                bytes(each.goal_info.goal_id.uuid): (_nanoseconds(each.goal_info.stamp), each.status)
                for each in array.status_list
            }
        if self._goal is None:
            return None
        state = self._state(pose is not None and math.dist(pose[:2], self._goal[:2]) <= TOLERANCE)
        if state < SUCCEEDED:
            return None
        self._goal = None
        return state == SUCCEEDED


class GoalTopic(Navigation):
    """Publish goals on ``goal_pose``; any middleware of ROS 2 takes them."""

    def __init__(self, node: Node, frame: str) -> None:
        super().__init__(node, frame)
        self._out = node.writer("geometry_msgs/msg/PoseStamped", "goal_pose", quality(1))
        self._before: set[bytes] = set()
        self._unsent, self._sent_at = False, 0.0

    def send(self, goal: Goal) -> None:
        """Publish a goal; that of a robot whose navigation has not started is published when it has."""
        self._goal, self._before, self._unsent = goal, set(self._states), True
        self._publish()

    def stop(self, pose: Pose | None) -> None:
        """Publish the robot's own pose as its goal: goals of the topic cannot be cancelled."""
        self._goal = None
        if pose is not None:
            self._out.write(pose_stamped(self._frame, *pose))

    def _publish(self) -> None:
        if self._unsent and self._goal is not None and self._out.get_matched_subscriptions():
            self._unsent, self._sent_at = False, time.monotonic()
            self._out.write(pose_stamped(self._frame, *self._goal))

    def _state(self, near: bool) -> int:
        """Return the state of the latest goal since the last one was published; Nav2 numbers them itself."""
        self._publish()
        known = [told for goal, told in self._states.items() if goal not in self._before]
        state = max(known)[1] if known else ACCEPTED
        early = time.monotonic() - self._sent_at < SETTLED
        return SUCCEEDED if near else ACCEPTED if early else state


class GoalAction(Navigation):
    """Call the action ``navigate_to_pose`` as a client of ``rmw_cyclonedds_cpp`` does."""

    def __init__(self, node: Node, frame: str) -> None:
        super().__init__(node, frame)
        self._send = Client(node, "nav2_msgs/action/NavigateToPose_SendGoal", f"{ACTION}send_goal")
        self._cancel = Client(node, "action_msgs/srv/CancelGoal", f"{ACTION}cancel_goal")
        self._id, self._request, self._refused = b"", 0, False

    def send(self, goal: Goal) -> None:
        """Ask for a goal, as soon as there is a server."""
        self._goal, self._request, self._refused = goal, 0, False
        self._ask()

    def stop(self, pose: Pose | None) -> None:
        """Cancel the goal."""
        if self._goal is not None and self._request:
            self._cancel.call(goal_info=new("action_msgs/msg/GoalInfo", goal_id=uuid(self._id)))
        self._goal = None

    def _ask(self) -> None:
        if self._goal is not None and not self._request and self._send.is_matched:
            self._id = secrets.token_bytes(16)
            pose = pose_stamped(self._frame, *self._goal)
            goal = new("nav2_msgs/action/NavigateToPose_Goal", pose=pose)
            self._request = self._send.call(goal_id=uuid(self._id), goal=goal)

    def _state(self, near: bool) -> int:
        self._ask()
        for answer in self._send.answers():
            self._refused |= answer.seq == self._request and not answer.accepted
        return ABORTED if self._refused else self._states.get(self._id, (0, ACCEPTED))[1]


def _nanoseconds(stamp: Any) -> int:
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)
