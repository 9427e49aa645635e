"""The explorer of one robot, without a transport: maps, poses and the ends of goals go in, goals come out.

At every tick::

    no map or pose yet            -> waiting     paused                          -> paused
    map or pose silent too long   -> silent      the robot stands, a mate nearby -> blocked: the pilot is asked again
    no frontier in reach          -> lift the bans; then done, once that has held for ``settle`` seconds
    else exploring: the pilot is asked in each cell that the robot enters, and once a goal was reached or has failed

What keeps the robot from exploring stops it, and it goes on when that ends. A goal that fails, is not reached in time,
or shows nothing new is banned for a while and given up after three times (:mod:`.bans`).
"""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Any, NamedTuple

import numpy as np

from indoor_explorers.env import InputError, Policy
from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.interfaces import GridFrame
from indoor_explorers.env.interfaces.ros import Goal
from indoor_explorers.env.policies.view import Message
from indoor_explorers.env.search.frontiers import frontier_mask
from indoor_explorers.evaluation.robot.bans import Bans, Point
from indoor_explorers.evaluation.robot.occupancy import MARGIN, belief_on, frame_on, occupancy_of
from indoor_explorers.evaluation.robot.piloting import Contact, Piloting, task_of, without
from indoor_explorers.evaluation.robot.reach import is_frontier, standing
from indoor_explorers.evaluation.robot.settings import RobotSettings

#: Metres: how far from a robot that stands in no free cell one is looked for; how near a mate may be in the way.
SNAP, NEAR = 1.0, 1.5
#: Seconds: the pose is silent, a mate is out of contact, a robot stands, a pilot that stays is asked again.
POSE_SILENCE, CONTACT, STALL, AGAIN = 5.0, 3.0, 5.0, 1.0


class State(StrEnum):
    """What an explorer does."""

    WAITING = "waiting"
    EXPLORING = "exploring"
    BLOCKED = "blocked"
    PAUSED = "paused"
    SILENT = "silent"
    DONE = "done"


class Command(NamedTuple):
    """What the robot is to do."""

    goal: Goal | None
    """Where to drive; None to stop."""


class _Mate(NamedTuple):
    point: Point
    message: Message
    at: float


class Explorer:
    """Explore with one robot; times are seconds of any clock that never runs back."""

    def __init__(self, policy: Policy, settings: RobotSettings) -> None:
        if policy.privileged:
            raise InputError("expected a policy that explores, got one that has to be given the map; choose another")
        self.settings, self._policy = settings, policy
        self._task = task_of(len(settings.robots), settings.lidar_range / settings.cell, settings.settings)
        self._bans = Bans(settings.ban, 2 * max(settings.cell, settings.radius))
        self.state, self.note, self.running = State.WAITING, "for a map", True
        self.frame: GridFrame | None = None
        self.piloting: Piloting | None = None
        self.target: Cell | None = None
        """The cell that the robot drives to."""
        self._belief: Belief | None = None
        self._pose: tuple[float, float, float] | None = None
        self._map_at = self._pose_at = -math.inf
        self._mates: dict[int, _Mate] = {}
        self._asked: tuple[Cell, float] | None = None
        self._arrival: Cell | None = None
        self._entered = (-1, -1), 0.0
        self._ended_at, self._leads_on, self._instead = 0.0, False, False
        self._bare_since: float | None = None

    def hear_map(self, grid: Any, now: float) -> None:
        """Take a ``nav_msgs/OccupancyGrid``; raise :class:`InputError` if it cannot be used."""
        occupancy, frame = occupancy_of(grid), self.frame
        if frame is None or (self.settings.area is None and not occupancy.is_within(frame)):
            area = self.settings.area or occupancy.bounds().with_margin(MARGIN)
            frame = frame_on(area, self.settings.cell)
        belief = belief_on(frame, occupancy, self.settings.radius)
        if frame is not self.frame:
            args: dict[str, int] = {"agent": self.settings.agent, "seed": self.settings.seed}
            self.frame, self.piloting = frame, Piloting(self._policy, frame, self._task, **args)
            self.target = self._asked = self._arrival = None
        self._belief, self._map_at = belief, now

    def hear_pose(self, x: float, y: float, yaw: float, now: float) -> None:
        """Take the robot's pose in the frame of the map, in metres and radians."""
        self._pose, self._pose_at = (x, y, yaw), now

    def hear_mate(self, name: str, x: float, y: float, message: Message, now: float) -> None:
        """Take a teammate's place in metres, and what its pilot last said."""
        if name != self.settings.name and name in self.settings.robots:
            self._mates[self.settings.robots.index(name)] = _Mate((x, y), message, now)

    def goal_ended(self, reached: bool, now: float, why: str = "") -> None:
        """Take the end of the present goal."""
        if self.target is None or self.frame is None:
            return
        self._ended_at, self._asked = now, None
        if reached:
            self._arrival = self.target
        else:
            self._fail(self.target, now, why or "navigation gave it up")
        self.target = None

    @property
    def pose(self) -> tuple[float, float, float] | None:
        """The robot's latest (x, y, yaw)."""
        return self._pose

    @property
    def status(self) -> str:
        """The state and what there is to say about it, in one line."""
        return f"{self.state}: {self.note}" if self.note else str(self.state)

    def frontier_points(self) -> list[Point]:
        """Return the centres of all frontier cells in metres."""
        if self.frame is None or self._belief is None:
            return []
        return [self.frame.point((row, col)) for row, col in np.argwhere(frontier_mask(self._belief)).tolist()]

    def tick(self, now: float) -> Command | None:
        """Return what the robot is to do from now on; None to go on as before."""
        held = self._held(now)
        if held is not None:
            self.state, self.note = held
            return self._halt()
        assert self.frame is not None
        cell, shown, nearest = self._situation(now)
        if cell != self._entered[0]:
            self._entered = cell, now
        if nearest is None:
            return self._bare(now)
        self._bare_since = None
        if self.state not in (State.EXPLORING, State.BLOCKED):
            self.state, self.note, self._asked = State.EXPLORING, "", None
        self._check_progress(cell, now)
        if self._arrival is not None and self._awaits_map(shown, now):
            return None
        return self._decide(shown, cell, nearest, now) if self._is_due(shown, cell, now) else None

    def _held(self, now: float) -> tuple[State, str] | None:
        """Return what keeps the robot from exploring, and why; None for nothing."""
        silence = self.settings.silence
        if not self.running:
            return State.PAUSED, "publish true on explore/resume to go on"
        if self._belief is None or self._pose is None:
            return State.WAITING, "for a map" if self._belief is None else "for the robot's pose"
        if silence and now - self._map_at > silence:
            return State.SILENT, f"no map for {silence:g} s"
        if now - self._pose_at > POSE_SILENCE:
            return State.SILENT, f"no pose for {POSE_SILENCE:g} s"
        return None if self._cell_of(self._pose[:2]) else (State.WAITING, "the robot is outside of the area")

    def _situation(self, now: float) -> tuple[Cell, Belief, Cell | None]:
        """Return the cell that the robot counts to be in, the belief with banned places as obstacles, and the frontier.

        That is the one nearest to the cell; None without one in reach.
        """
        assert self._belief is not None
        assert self._pose is not None
        own = self._cell_of(self._pose[:2]) or (0, 0)
        banned = [cell for point in self._bans.active(now) if (cell := self._cell_of(point))]
        reach = max(1, round(self.settings.radius / self.settings.cell))
        shown = without(self._belief, banned, reach, own)
        cell, nearest = standing(shown, own, max(SNAP / self.settings.cell, 2.0))
        return cell, shown, nearest

    def _bare(self, now: float) -> Command | None:
        """Return what to do while no frontier can be reached."""
        if self._bans.lift(now):
            self._asked = None
            return None
        self._bare_since = now if self._bare_since is None else self._bare_since
        if now - self._bare_since >= self.settings.settle:
            lost = self._bans.given_up
            self.state, self.note = State.DONE, "no frontier is left" + (f" but {lost} given up" if lost else "")
        elif self.state is not State.DONE:
            self.state, self.note = State.EXPLORING, "no frontier in reach; waiting for the map"
        return self._halt()

    def _check_progress(self, cell: Cell, now: float) -> None:
        """See to a robot that stands on its way: a mate may be in it, or the goal has failed."""
        idle = now - max(self._entered[1], self._ended_at)
        if self.target is None or idle < STALL:
            if self.state is State.BLOCKED:
                self.state, self.note = State.EXPLORING, ""
            return
        mate = self._mate_nearby(now)
        if mate is not None:
            self.state, self.note = State.BLOCKED, f"by {mate}"
        if idle >= self.settings.patience:
            self._fail(self.target, now, "not reached in time", strike=mate is None)
            self.target, self._asked, self._ended_at = None, None, now

    def _mate_nearby(self, now: float) -> str | None:
        assert self._pose is not None
        for agent, mate in self._mates.items():
            if now - mate.at <= CONTACT and math.dist(mate.point, self._pose[:2]) <= NEAR:
                return self.settings.robots[agent]
        return None

    def _awaits_map(self, shown: Belief, now: float) -> bool:
        """Tell whether the map has yet to show what is around the place of arrival; ban it if it never does."""
        assert self._arrival is not None
        if is_frontier(shown, self._arrival):
            if now - self._ended_at < self.settings.settle:
                return True
            self._fail(self._arrival, now, "nothing new there")
            shown[...] = self._situation(now)[1]
        self._arrival = None
        return False

    def _is_due(self, shown: Belief, cell: Cell, now: float) -> bool:
        """Tell whether to ask the pilot now."""
        if self._instead and self.target is not None:
            return False
        if self._asked is None or self._asked[0] != cell:
            return True
        waited = now - self._asked[1]
        if self.target is None:
            return waited >= AGAIN
        spent = self._leads_on and not is_frontier(shown, self.target)
        return waited >= (AGAIN if spent else STALL if self.state is State.BLOCKED else math.inf)

    def _decide(self, shown: Belief, cell: Cell, nearest: Cell, now: float) -> Command | None:
        """Ask the pilot for a way; return the goal at its end, if that is another one."""
        assert self.frame is not None
        assert self.piloting is not None
        self._asked = cell, now
        way = self.piloting.decide(shown, cell, self._contacts(now))
        self._instead = len(way) == 1 and now - max(self._entered[1], self._ended_at) >= self.settings.patience
        if self._instead:
            way, self.note = [cell, nearest], "the policy stays; the nearest frontier instead"
            self._ended_at = now
        if way[-1] == cell:
            if is_frontier(shown, cell):
                self._arrival, self._ended_at = cell, now
            return self._halt()
        if way[-1] == self.target:
            return None
        if self.target is None:
            self._ended_at = now
        self.target, self._leads_on = way[-1], is_frontier(shown, way[-1])
        down, right = way[-1][0] - way[-2][0], way[-1][1] - way[-2][1]
        return Command(Goal(*self.frame.point(way[-1]), math.atan2(-down, right)))

    def _contacts(self, now: float) -> list[Contact]:
        found = ((agent, self._cell_of(mate.point), mate) for agent, mate in sorted(self._mates.items()))
        return [(agent, cell, mate.message) for agent, cell, mate in found if cell and now - mate.at <= CONTACT]

    def _fail(self, cell: Cell, now: float, why: str, *, strike: bool = True) -> None:
        assert self.frame is not None
        x, y = self.frame.point(cell)
        self._bans.add((x, y), now, strike=strike)
        self.note = f"the goal ({x:.2f}, {y:.2f}) is banned for {self.settings.ban:g} s: {why}"

    def _halt(self) -> Command | None:
        """Give up the goal; return the command to stop if the robot is driving."""
        driving, self.target = self.target is not None, None
        return Command(None) if driving else None

    def _cell_of(self, point: Point) -> Cell | None:
        """Return the cell of a point in metres; None off the frame."""
        assert self.frame is not None
        try:
            return self.frame.cell(*point)
        except InputError:
            return None
