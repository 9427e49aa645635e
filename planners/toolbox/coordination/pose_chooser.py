"""The choice of a pose by the best short sequence that begins there, in turn with the linked teammates.

Members of a group know each other's headings by their messages: the goal (row, column), its heading, and the heading
that the UAV has after the action of the step.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell, Distances, Mask
from indoor_explorers.env.grid.cells import TURN, UNREACHABLE, Action
from indoor_explorers.env.policies.view import Mate, Message, View
from indoor_explorers.planners.toolbox.coordination.sequence_chooser import (
    HOP_RANGES,
    SequenceChooser,
    SequenceParameters,
)
from indoor_explorers.planners.toolbox.information.pose_views import Camera, pose_views
from indoor_explorers.planners.toolbox.navigation.candidate_pilot import CandidatePilot
from indoor_explorers.planners.toolbox.navigation.pose_navigator import Pose
from indoor_explorers.planners.toolbox.navigation.poses import ANY, pose_steps, steps_between
from indoor_explorers.planners.toolbox.navigation.teammates import linked, sent_goal
from indoor_explorers.planners.toolbox.routing.sequences import DecisionProblem

#: Numbers of a message.
_LENGTH = 4


class PoseMember(NamedTuple):
    """One UAV of a group, as the others know it."""

    agent: int
    pose: Pose
    goal: Pose | None


class Poses(NamedTuple):
    """K candidates."""

    cells: NDArray[np.int32]
    """(K,) flat cells."""
    headings: NDArray[np.int64]
    """(K,)"""
    ahead: Mask
    """(K,) bool, whether they stand for a frontier cluster, at most one each."""


#: Returns the candidates, from a view, the steps from the UAVs of the group, (N, H, W), and their poses.
PoseCandidates = Callable[[View, Distances, list[Pose]], Poses]


def pose_message(view: View, goal: Pose | None, action: int) -> Message:
    """Return the message of a UAV that takes an action."""
    heading = view.heading or 0
    heading = (heading + 1) % 4 if action == TURN else heading if action == Action.STAY else action
    row, col = goal.cell if goal else (-1, -1)
    return float(row), float(col), float(goal.heading if goal else ANY), float(heading)


def _member(mate: Mate) -> PoseMember:
    goal, numbers = sent_goal(mate), mate.message
    if numbers is None or len(numbers) != _LENGTH:
        return PoseMember(mate.agent, Pose(mate.cell, ANY), Pose(goal, ANY) if goal else None)
    return PoseMember(mate.agent, Pose(mate.cell, int(numbers[3])), Pose(goal, int(numbers[2])) if goal else None)


class PoseChooser(SequenceChooser):
    """Choose the pose that a UAV gets in its turn.

    Args:
        pilot: The pilot that flies to the poses.
        parameters: How candidates are compared.
        camera: The lidar of all UAVs.
        values: Returns the values of unknown cells in a view, (H*W,).
        poses: Returns the candidates of a decision.

    """

    def __init__(
        self,
        pilot: CandidatePilot,
        parameters: SequenceParameters,
        camera: Camera,
        values: Callable[[View], NDArray[np.float64]],
        poses: PoseCandidates,
    ) -> None:
        super().__init__(pilot, parameters, _no_candidates)
        self._camera, self._values, self._poses = camera, values, poses

    def choose_pose(self, view: View, goal: Pose | None) -> Pose | None:
        """Return the pose that this UAV gets, which flies to ``goal`` now; None if it can reach none."""
        own = PoseMember(self._pilot.briefing.agent, Pose(view.cell, view.heading or 0), goal)
        members = sorted([own, *(_member(mate) for mate in linked(view))])
        problem, headings = self.pose_problem(view, members)
        candidate = self.candidate(view, problem, [member.agent for member in members])
        if candidate is None:
            return None
        return Pose(divmod(int(problem.cells[candidate]), self._pilot.paths.width), int(headings[candidate]))

    def pose_problem(self, view: View, members: list[PoseMember]) -> tuple[DecisionProblem, NDArray[np.int64]]:
        """Return the decision problem of a group, and the headings of its K candidates, (K,)."""
        pilot, reach, starts = self._pilot, self._range, [member.pose for member in members]
        fields = np.stack([pilot.steps_from(view, pose.cell) for pose in starts])
        poses = self._poses(view, fields, starts)
        fine = ~pilot.near_banned(view, poses.cells)
        cells, headings, ahead = (each[fine] for each in poses)
        gains, shared = pose_views(view.belief, cells, headings, self._values(view), self._camera)
        facing = np.array([pose.heading for pose in starts])
        steps = pose_steps(fields, pilot.paths.flat(pose.cell for pose in starts), facing, cells, headings)
        limit = int(HOP_RANGES * reach) + 1
        between = steps_between(view.belief, cells, headings, steps.astype(np.float64), limit)
        hysteresis = np.stack([self._bonus(member.goal, cells, headings) for member in members])
        away = np.where(steps < UNREACHABLE, steps / reach, UNREACHABLE)
        return DecisionProblem(cells, ahead, away, between / reach, gains, shared, hysteresis), headings

    def _bonus(
        self, goal: Pose | None, cells: NDArray[np.int32], headings: NDArray[np.int64]
    ) -> NDArray[np.float64]:
        """Return the factors on the utilities of K poses for a UAV's goal, (K,)."""
        factors = self._pilot.hysteresis_bonus(goal.cell if goal else None, cells, self.parameters.goal_bonus)
        return np.where(goal.heading == headings, factors, 1.0) if goal else factors


def _no_candidates(view: View, fields: Distances) -> tuple[NDArray[np.int32], Mask]:
    return np.empty(0, np.int32), np.empty(0, np.bool_)
