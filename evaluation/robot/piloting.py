"""The pilot of one robot: it decides in each cell that the robot enters, and its way leads to a goal some cells on.

A pilot that tells its path is followed along it. For one that only tells its next move, a copy of it moves on in
thought, over the map as it is, up to the first cell beside unknown ones.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from indoor_explorers.env import Briefing, Explanation, Pilot, Policy, Scenario
from indoor_explorers.env.errors import RunError, described
from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import FREE, MOVES, OCCUPIED, UNKNOWN
from indoor_explorers.env.interfaces import GridFrame, Robot
from indoor_explorers.env.interfaces.ros import LOG_ODDS
from indoor_explorers.env.policies.policy import checked_action
from indoor_explorers.env.policies.view import Message
from indoor_explorers.evaluation.robot.reach import is_frontier

#: Least moves of which a pilot that tells no path is asked.
LEAST_AHEAD = 4

#: A teammate in contact: its number, its cell, and what its pilot last said.
Contact = tuple[int, Cell, Message]


def task_of(team: int, lidar_range: float, settings: Mapping[str, Any]) -> Scenario:
    """Return what pilots are told of the task: the team, the lidar's range in cells, and further settings."""
    facts = {"team": team, "lidar.range": max(lidar_range, 1.0), "budget": 10_000_000, "on_collision": "block"}
    facts |= {"radio.model": "unlimited" if team > 1 else "none", "goal": 1.0}
    return Scenario(name="robot").for_evaluation().with_settings(facts | dict(settings))


class Piloting:
    """Ask the pilot of one robot on the cells of a frame."""

    def __init__(self, policy: Policy, frame: GridFrame, task: Scenario, *, agent: int, seed: int) -> None:
        self.frame, self.policy = frame, policy
        briefing = Briefing(
            agent=agent,
            team=task.team,
            shape=frame.shape,
            lidar_range=task.lidar.range,
            scenario=task,
            rng=np.random.default_rng([seed, agent]),
        )
        self.pilot = policy.pilot(briefing)
        self.pilot.explaining = True
        self.ahead = max(math.ceil(task.lidar.range), LEAST_AHEAD)
        self.way: list[Cell] = []
        """The cells from the robot's on to where it is to drive; a single one to stay."""
        self._robot = Robot(frame, budget=max(200, frame.shape[0] * frame.shape[1]))

    @property
    def message(self) -> Message:
        """What the pilot tells its teammates."""
        return self.pilot.message

    def explain(self) -> Explanation | None:
        """Return what the pilot chose among."""
        return self.pilot.explain()

    def decide(self, belief: Belief, cell: Cell, contacts: Iterable[Contact]) -> list[Cell]:
        """Ask the pilot in a cell, where it was not asked before or the last way has ended; return the new way."""
        for agent, place, message in contacts:
            self._robot.hear(agent, self.frame.point(place), message)
        action = self._act(self.pilot, self._robot, belief, cell)
        following = moved(belief, cell, action)
        told = self.pilot.explain()
        path = list(told.path) if told is not None else []
        if len(path) > 2 and path[:2] == [cell, following]:
            self.way = path
        elif following == cell or self._is_on_way(belief, cell, following):
            self.way = [cell] if following == cell else self.way[self.way.index(cell) :]
        else:
            self.way = self._imagined(belief, [cell, following])
        return self.way

    def _is_on_way(self, belief: Belief, cell: Cell, following: Cell) -> bool:
        """Tell whether a move is the next one of the present way, which still ends beside unknown cells."""
        if cell not in self.way[:-1] or self.way[self.way.index(cell) + 1] != following:
            return False
        return is_frontier(belief, self.way[-1])

    def _imagined(self, belief: Belief, way: list[Cell]) -> list[Cell]:
        """Return a way of two cells with the moves that a copy of the pilot would make from there on."""
        try:
            pilot, robot = copy.deepcopy((self.pilot, self._robot))
        except TypeError:  # a pilot that cannot be copied
            return way
        while len(way) <= self.ahead and not is_frontier(belief, way[-1]):
            following = moved(belief, way[-1], self._act(pilot, robot, belief, way[-1]))
            if following in way:
                break
            way.append(following)
        return way

    def _act(self, pilot: Pilot, robot: Robot, belief: Belief, cell: Cell) -> int:
        grid = robot.frame.occupancy(belief).reshape(belief.shape)
        view = robot.view(grid, robot.frame.point(cell))
        view = view._replace(log_odds=LOG_ODDS[view.belief])  # so that pilots look for cells that have changed
        try:
            return checked_action(self.policy.act([pilot], [view])[0])
        except Exception as error:
            raise RunError(f"the policy failed at step {view.step}: {described(error)}") from error


def moved(belief: Belief, cell: Cell, action: int) -> Cell:
    """Return the cell that an action leads to on a (H, W) belief: the cell itself if the other one is not free."""
    row, col = (MOVES[action] + cell).tolist()
    inside = 0 <= row < belief.shape[0] and 0 <= col < belief.shape[1]
    return (row, col) if inside and belief[row, col] == FREE else cell


def without(belief: Belief, places: Iterable[Cell], reach: int, own: Cell) -> Belief:
    """Return a belief on which places and the unknown cells at most ``reach`` rows and columns away are obstacles."""
    shown = belief.copy()
    for row, col in places:
        around = shown[max(row - reach, 0) : row + reach + 1, max(col - reach, 0) : col + reach + 1]
        around[around == UNKNOWN] = OCCUPIED
        if (row, col) != own:
            shown[row, col] = OCCUPIED
    return shown
