"""The explorer of one robot as a ROS 2 node: topics, frames and Nav2's action around the core of the package.

It has not been run with ROS here; a test runs it with stand-ins for ROS.
"""

from __future__ import annotations

import time

import rclpy
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Point
from nav2_msgs.action import NavigateToPose
from nav_msgs.msg import OccupancyGrid
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool, ColorRGBA, String
from tf2_ros import Buffer, TransformException, TransformListener
from visualization_msgs.msg import Marker, MarkerArray

from indoor_explorers.env import make_policy
from indoor_explorers.env.interfaces.ros import ADD, DELETE
from indoor_explorers.evaluation.robot.drawings import drawings
from indoor_explorers.evaluation.robot.explorer import Explorer
from indoor_explorers.evaluation.robot.occupancy import yaw_of
from indoor_explorers.evaluation.robot.settings import RobotSettings

#: Parameters of the node besides the policy, with those of the core as their defaults.
NUMBERS = ("cell", "radius", "lidar_range", "silence", "patience", "ban", "settle")
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class ExplorerNode(Node):
    """Explore with one robot."""

    def __init__(self) -> None:
        super().__init__("explorer")
        policy = self.declare_parameter("policy", "frontier").value
        defaults = RobotSettings()
        numbers = {name: self.declare_parameter(name, float(getattr(defaults, name))).value for name in NUMBERS}
        self.explorer, self.handle, self.told = Explorer(make_policy(policy), RobotSettings(**numbers)), None, ""
        self.buffer = Buffer()
        self.listener = TransformListener(self.buffer, self)
        self.navigation = ActionClient(self, NavigateToPose, "navigate_to_pose")
        self.create_subscription(OccupancyGrid, "map", self.hear_map, LATCHED)
        self.create_subscription(Bool, "explore/resume", self.switch, 10)
        self.status = self.create_publisher(String, "explore/status", LATCHED)
        self.markers = self.create_publisher(MarkerArray, "explore/frontiers", LATCHED)
        self.create_timer(0.1, self.tick)
        self.create_timer(1.0, self.show)

    def hear_map(self, grid: OccupancyGrid) -> None:
        """Take a map."""
        self.explorer.hear_map(grid, time.monotonic())

    def switch(self, message: Bool) -> None:
        """Pause or resume."""
        self.explorer.running = message.data

    def tick(self) -> None:
        """Look up the pose, ask the core, and send what it wants to Nav2."""
        try:
            moved = self.buffer.lookup_transform("map", "base_link", rclpy.time.Time()).transform
            place = moved.translation
            self.explorer.hear_pose(place.x, place.y, yaw_of(moved.rotation), time.monotonic())
        except TransformException:
            pass  # the core notices a silent pose
        command = self.explorer.tick(time.monotonic())
        if command is not None and self.handle is not None and command.goal is None:
            self.handle.cancel_goal_async()
        if command is not None and command.goal is not None:
            self.send(command.goal)
        if self.explorer.status != self.told:
            self.told = self.explorer.status
            self.get_logger().info(self.told)
            self.status.publish(String(data=self.told))

    def send(self, goal) -> None:
        """Send a goal to Nav2; what becomes of an earlier one no longer counts."""
        message = NavigateToPose.Goal()
        message.pose.header.frame_id = "map"
        message.pose.pose.position.x, message.pose.pose.position.y = goal.x, goal.y
        turn = message.pose.pose.orientation
        turn.x, turn.y, turn.z, turn.w = goal.quaternion
        sent = self.navigation.send_goal_async(message)
        sent.add_done_callback(lambda done: self.accepted(done.result(), goal))
        self.goal = goal

    def accepted(self, handle, goal) -> None:
        """Wait for the end of a goal."""
        if goal is not self.goal:
            return
        if not handle.accepted:
            self.explorer.goal_ended(False, time.monotonic(), "navigation refused it")
            return
        self.handle = handle
        handle.get_result_async().add_done_callback(lambda done: self.ended(done.result().status, goal))

    def ended(self, status: int, goal) -> None:
        """Tell the core how its latest goal has ended."""
        if goal is self.goal:
            self.explorer.goal_ended(status == GoalStatus.STATUS_SUCCEEDED, time.monotonic())

    def show(self) -> None:
        """Publish frontiers, candidates, goal and way."""
        array = MarkerArray()
        for number, drawing in enumerate(drawings(self.explorer)):
            marker = Marker(ns=drawing.name, id=number, type=drawing.kind, action=ADD if drawing.points else DELETE)
            marker.header.frame_id, marker.pose.orientation.w = "map", 1.0
            marker.scale.x = marker.scale.y = marker.scale.z = drawing.size
            marker.points = [Point(x=x, y=y) for x, y in drawing.points]
            marker.colors = [ColorRGBA(r=r, g=g, b=b, a=a) for r, g, b, a in drawing.colours]
            array.markers.append(marker)
        self.markers.publish(array)


def main() -> None:
    """Run the node until it is interrupted."""
    rclpy.init()
    rclpy.spin(ExplorerNode())
