"""Simulated robots with the topics, services and qualities of service of a mapper and Nav2, for trials and tests.

The building is a map of this package. Robots see it by its lidar, publish their maps and frames, and drive along
shortest paths through the cells that they know, one at a time in a cell.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE, MOVES, OCCUPIED, UNKNOWN, UNREACHABLE
from indoor_explorers.env.interfaces import GridFrame
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.sensing.lidar import scan
from indoor_explorers.env.simulation.spawns import draw_floorplan, draw_spawns
from indoor_explorers.evaluation.robot.bans import Point
from indoor_explorers.evaluation.robot.dds import Node, Server, quality, taken
from indoor_explorers.evaluation.robot.messages import new, point, turned, uuid
from indoor_explorers.evaluation.robot.navigation import ABORTED, ACTION, CANCELED, EXECUTING, SUCCEEDED

#: Pixels of the published map along the side of a cell of the building; goals that a status array lists.
PIXELS, LISTED = 4, 10
#: Percents of the free cells whose knowledge is told.
MARKS = (10, 20, 30, 40, 50, 60, 70, 80, 90, 95, 99, 100)
#: Seconds between two ticks and between two maps; that a robot waits for another one before it gives up its goal.
TICK, MAP_PERIOD, WAIT = 0.05, 0.5, 6.0


@dataclass(frozen=True, kw_only=True)
class Simulation:
    """Describe simulated robots."""

    scenario: Scenario
    seed: int = 0
    names: tuple[str, ...] = ("",)
    speed: float = 0.5
    """Metres a second."""
    shared: bool = False
    """Whether the robots have one map, on the topic ``/map``."""
    mute: tuple[float, float] = (math.inf, math.inf)
    """Seconds from the start between which no map is published."""


class SimulatedRobot:
    """One robot: its place, its knowledge, its goal and its topics."""

    def __init__(self, name: str, start: Cell, frame: GridFrame, map_topic: str) -> None:
        self.frame, self.place = frame, frame.point(start)
        self.belief: Belief = np.full(frame.shape, UNKNOWN, np.uint8)
        self._scanned: Cell | None = None
        self._yaw, self._waited, self.driven = 0.0, 0.0, 0.0
        self._goal: tuple[bytes, Point] | None = None
        self._goals: list[tuple[bytes, tuple[int, int], int]] = []
        node, latched = Node(name), quality(1, latched=True)
        self._map = node.writer("nav_msgs/msg/OccupancyGrid", map_topic, latched)
        self._tf = node.writer("tf2_msgs/msg/TFMessage", "tf", quality(100))
        self._fixed = node.writer("tf2_msgs/msg/TFMessage", "tf_static", latched)
        self._goal_pose = node.reader("geometry_msgs/msg/PoseStamped", "goal_pose", quality(10))
        self._send = Server(node, "nav2_msgs/action/NavigateToPose_SendGoal", f"{ACTION}send_goal")
        self._cancel = Server(node, "action_msgs/srv/CancelGoal", f"{ACTION}cancel_goal")
        self._status = node.writer("action_msgs/msg/GoalStatusArray", f"{ACTION}status", latched)
        self._fixed.write(_transforms("base_footprint", "base_link", 0.0, 0.0, 0.0))

    @property
    def cell(self) -> Cell:
        """The robot's cell of the building."""
        return self.frame.cell(*self.place)

    def hear(self) -> None:
        """Take goals and their ends."""
        for pose in taken(self._goal_pose):
            self._accept(np.random.default_rng().bytes(16), pose.pose.position)
        for request in self._send.requests():
            self._send.answer(request, accepted=True, stamp=_now())
            self._accept(bytes(request.goal_id.uuid), request.goal.pose.pose.position)
        for request in self._cancel.requests():
            known = self._goal is not None and self._goal[0] == bytes(request.goal_info.goal_id.uuid)
            self._cancel.answer(request, goals_canceling=[request.goal_info] if known else [])
            if known:
                self._end(CANCELED)

    def drive(self, far: float, others: list[Point]) -> None:
        """Drive up to ``far`` metres towards the goal, around others if that is possible; else they are waited for."""
        if self._goal is None:
            return
        following = self._next_point(self._goal[1], others) or self._next_point(self._goal[1], [])
        if following is None:
            self._end(ABORTED)
            return
        x, y = following[0] - self.place[0], following[1] - self.place[1]
        left = math.hypot(x, y)
        if any(math.dist(other, following) < 0.7 * self.frame.resolution for other in others):
            self._waited += TICK
            if self._waited > WAIT:
                self._end(ABORTED)
            return
        self._waited = 0.0
        if left > 1e-9:
            share = min(far / left, 1.0)
            self.driven += share * left
            self._yaw, self.place = math.atan2(y, x), (self.place[0] + share * x, self.place[1] + share * y)
        if math.dist(self.place, self._goal[1]) < 1e-6:
            self._end(SUCCEEDED)

    def look(self, truth: Belief, task: Scenario) -> None:
        """Scan a building from a cell that the robot has entered."""
        if self.cell != self._scanned:
            self._scanned = self.cell
            seen = scan(truth, self.cell, task.lidar.range, task.lidar.model)
            np.copyto(self.belief, seen, where=seen != UNKNOWN)

    def publish(self, with_map: bool) -> None:
        """Publish the robot's frames, and its map."""
        self._tf.write(_transforms("map", "odom", 0.0, 0.0, 0.0))
        self._tf.write(_transforms("odom", "base_footprint", *self.place, self._yaw))
        if with_map:
            fine = GridFrame(
                shape=(self.frame.shape[0] * PIXELS, self.frame.shape[1] * PIXELS),
                resolution=self.frame.resolution / PIXELS,
                origin=self.frame.origin,
            )
            belief = np.repeat(np.repeat(self.belief, PIXELS, axis=0), PIXELS, axis=1)
            origin = new("geometry_msgs/msg/Pose", position=point(*fine.origin), orientation=turned(0.0))
            height, width = fine.shape
            sizes = {"resolution": fine.resolution, "width": width, "height": height}
            info = new("nav_msgs/msg/MapMetaData", origin=origin, **sizes)
            data = fine.occupancy(belief).tolist()
            self._map.write(new("nav_msgs/msg/OccupancyGrid", header=_header("map"), info=info, data=data))

    def _next_point(self, goal: Point, others: list[Point]) -> Point | None:
        """Return where to drive next on the way to a goal around others, in metres; None without a way."""
        try:
            target = self.frame.cell(*goal)
        except InputError:
            return None
        if target == self.cell:
            return goal
        around = self.belief.copy()
        for other in others:
            around[self.frame.cell(*other)] = OCCUPIED
        steps = distance_field(around, target)
        if around[target] != FREE or steps[self.cell] >= UNREACHABLE:
            return None
        row, col = next(
            (row, col)
            for row, col in (np.array(self.cell) + MOVES[:4]).tolist()
            if 0 <= row < steps.shape[0] and 0 <= col < steps.shape[1] and steps[row, col] < steps[self.cell]
        )
        return self.frame.point((row, col))

    def _accept(self, number: bytes, position: Any) -> None:
        if self._goal is not None:
            self._end(ABORTED)
        stamp = _now()
        self._goal, self._waited = (number, (position.x, position.y)), 0.0
        self._goals = [*self._goals[1 - LISTED :], (number, (stamp.sec, stamp.nanosec), EXECUTING)]
        self._tell()

    def _end(self, state: int) -> None:
        assert self._goal is not None
        number, self._goal = self._goal[0], None
        self._goals = [(each, at, state if each == number else before) for each, at, before in self._goals]
        self._tell()

    def _tell(self) -> None:
        listed = [
            new(
                "action_msgs/msg/GoalStatus",
                goal_info=new(
                    "action_msgs/msg/GoalInfo",
                    goal_id=uuid(number),
                    stamp=new("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec),
                ),
                status=state,
            )
            for number, (sec, nanosec), state in self._goals
        ]
        self._status.write(new("action_msgs/msg/GoalStatusArray", status_list=listed))


def simulate(simulation: Simulation, say: Callable[[str], None]) -> None:
    """Simulate robots until interrupted; ``say`` gets a line for each of :data:`MARKS` that they reach."""
    task = simulation.scenario.with_settings({"team": len(simulation.names)})
    plan = draw_floorplan(task, simulation.seed)
    truth, reachable = np.pad(plan.truth, 1, constant_values=OCCUPIED), np.pad(plan.main_part, 1)
    frame = GridFrame(shape=truth.shape, resolution=plan.resolution or 1.0)
    starts = [(row + 1, col + 1) for row, col in draw_spawns(task, plan, simulation.seed)]
    topic = "/map" if simulation.shared else "map"
    robots = [SimulatedRobot(*each, frame, topic) for each in zip(simulation.names, starts, strict=True)]
    for robot in robots if simulation.shared else ():
        robot.belief = robots[0].belief
    begun, mapped, told = time.monotonic(), -math.inf, 0
    while True:
        now = time.monotonic() - begun
        with_map = now - mapped >= MAP_PERIOD and not simulation.mute[0] <= now < simulation.mute[1]
        mapped = now if with_map else mapped
        for robot in robots:
            robot.hear()
            robot.drive(simulation.speed * TICK, [other.place for other in robots if other is not robot])
            robot.look(truth, task)
            robot.publish(with_map and (not simulation.shared or robot is robots[0]))
        known = np.any([robot.belief == FREE for robot in robots], axis=0)
        percent = max((mark for mark in MARKS if mark <= 100 * known[reachable].mean()), default=0)
        if percent > told:
            told = percent
            say(f"{percent} % of the free cells known after {sum(robot.driven for robot in robots):.1f} m")
        time.sleep(TICK)


def _header(frame: str) -> Any:
    return new("std_msgs/msg/Header", stamp=_now(), frame_id=frame)


def _now() -> Any:
    sec, nanosec = divmod(time.time_ns(), 1_000_000_000)
    return new("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec)


def _transforms(frame: str, child: str, x: float, y: float, yaw: float) -> Any:
    place = new("geometry_msgs/msg/Vector3", x=x, y=y)
    moved = new("geometry_msgs/msg/Transform", translation=place, rotation=turned(yaw))
    stamped = new("geometry_msgs/msg/TransformStamped", header=_header(frame), child_frame_id=child, transform=moved)
    return new("tf2_msgs/msg/TFMessage", transforms=[stamped])
