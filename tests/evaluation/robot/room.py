"""A building and a robot in it for tests of the explorer, without a transport."""

from types import SimpleNamespace

import numpy as np

from indoor_explorers.env import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.interfaces import GridFrame
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.sensing.lidar import scan


def grid_of(values, resolution, x=0.0, y=0.0, yaw=0.0, tilt=0.0):
    """A ``nav_msgs/OccupancyGrid`` of (h, w) values, whose first row lies at the origin."""
    turn = SimpleNamespace(x=tilt, y=0.0, z=np.sin(yaw / 2), w=np.cos(yaw / 2))
    origin = SimpleNamespace(position=SimpleNamespace(x=x, y=y), orientation=turn)
    height, width = np.shape(values)
    info = SimpleNamespace(resolution=resolution, width=width, height=height, origin=origin)
    return SimpleNamespace(info=info, data=np.ravel(values).tolist())


def building(text):
    """The truth (H, W) of lines of ``#`` and others."""
    return np.array([[OCCUPIED if sign == "#" else FREE for sign in line] for line in text.split()], np.uint8)


class Room:
    """A robot of 1 m cells that sees 3 cells far and arrives in one step, where its map knows a way."""

    def __init__(self, truth, start, fails=()):
        self.truth, self.cell, self.fails = truth, start, set(fails)
        self.frame = GridFrame(shape=truth.shape)
        self.belief = np.full(truth.shape, UNKNOWN, np.uint8)
        self.goals = []
        self.look()

    def look(self):
        seen = scan(self.truth, self.cell, 3.0)
        np.copyto(self.belief, seen, where=seen != UNKNOWN)

    def tell(self, explorer, now):
        pixels = np.repeat(np.repeat(self.frame.occupancy(self.belief).reshape(self.truth.shape), 2, 0), 2, 1)
        explorer.hear_map(grid_of(pixels, 0.5), now)
        explorer.hear_pose(*self.frame.point(self.cell), 0.0, now)

    def obey(self, explorer, goal, now):
        """Arrive at a goal, or fail."""
        target = self.frame.cell(goal.x, goal.y)
        self.goals.append(target)
        reached = target not in self.fails and distance_field(self.belief, target)[self.cell] < self.truth.size
        if reached:
            self.cell = target
            self.look()
        explorer.goal_ended(reached, now)

    def explore(self, explorer, seconds=400.0):
        """Explore until it is done; return the time."""
        now = 0.0
        while explorer.state != "done" and now < seconds:
            self.tell(explorer, now)
            command = explorer.tick(now)
            if command is not None and command.goal is not None:
                self.obey(explorer, command.goal, now)
            now += 1.0
        return now
