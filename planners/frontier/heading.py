"""Frontier clusters and headings: sequences of poses whose sectors show the most, and ways that see much."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell, Distances, Mask
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.sensing.field_of_view import ALL_AROUND
from indoor_explorers.planners.frontier.joint import FrontierJoint, JointPilot
from indoor_explorers.planners.toolbox.coordination.pose_chooser import PoseChooser, Poses, pose_message
from indoor_explorers.planners.toolbox.information.candidates import UnknownWeight, frontier_candidates
from indoor_explorers.planners.toolbox.information.pose_views import HEADINGS, camera, heading_gains, shows_new, unknown_weights
from indoor_explorers.planners.toolbox.navigation.candidate_pilot import CandidatePilot
from indoor_explorers.planners.toolbox.navigation.pose_navigator import Pose, PoseNavigator
from indoor_explorers.planners.toolbox.navigation.poses import ANY, pose_steps
from indoor_explorers.planners.toolbox.navigation.view_paths import WayParameters
from indoor_explorers.planners.toolbox.parameters import bounded


@renamed()
@dataclass(frozen=True, kw_only=True)
class FrontierHeading(FrontierJoint):
    """Fly to the candidate pose with the best short sequence, by ways that see much.

    As ``frontier-joint``, for a lidar with a limited field of view. Candidates are poses, cells with a heading: the gain
    of a pose is that of its sector (A. Bircher et al., ICRA 2016, doi:10.1109/ICRA.2016.7487281; M. Selin et al., RA-L
    2019, doi:10.1109/LRA.2019.2897343), and the way to it counts moves and the turns in place that are left at its end.
    Poses near a UAV are candidates too, among them turns where it is. While it flies, a UAV chooses among ways that are
    at most ``slack`` steps longer than a shortest one (B. Zhou et al., FUEL, RA-L 2021,
    doi:10.1109/LRA.2021.3051563). Where the lidar sees all around, the policy is ``frontier-joint``.
    """

    lookouts: int = bounded(16, least=0)
    headings: int = bounded(2, least=1)
    """Most headings of a cluster's cell that are candidates."""
    slack: int = bounded(3, least=0)
    """Most steps that a way may be longer than a shortest one."""
    price: float = bounded(2.0, least=0)
    """Weight of unknown cells that each of these steps has to show."""
    reach: float = bounded(2.0, least=0)
    """Length of the part of a way that is chosen by what it shows, in lidar ranges."""
    depth: float = bounded(2.0, least=0)
    """Decay."""
    width: int = bounded(16, least=1)
    """Ways kept at each step of the search."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        narrow = briefing.scenario.lidar.field_of_view < ALL_AROUND
        return HeadingPilot(briefing, self) if narrow else JointPilot(briefing, self)


class HeadingPilot(CandidatePilot):
    """Choose a pose in turn with the linked teammates, some steps after the map has grown."""

    navigator: PoseNavigator

    def __init__(self, briefing: Briefing, policy: FrontierHeading) -> None:
        self._policy, self._range = policy, float(briefing.lidar_range)
        self._camera = camera(self._range, briefing.scenario.lidar.field_of_view)
        self._weight = UnknownWeight(policy.isolation, policy.decay_length * self._range)
        self._valued: tuple[Belief, NDArray[np.float64]] | None = None
        super().__init__(briefing)
        self.replan_period = self.steps_in(policy.period)
        self.chooser = PoseChooser(self, policy, self._camera, self.values, self.poses)
        """Chooses among the poses."""
        self._seen_from: set[Pose] = set()

    def new_navigator(self, briefing: Briefing) -> PoseNavigator:
        """Return the navigator of an episode."""
        policy = self._policy
        ways = WayParameters(policy.price, policy.slack, max(1, round(policy.reach * self._range)), policy.width)
        return PoseNavigator(briefing, self._camera, self.on_the_way, ways)

    def act(self, view: View) -> int:
        """Follow the way to the goal, choose another goal if due, and tell both headings."""
        self._valued = None
        action = super().act(view)
        self.message = pose_message(view, self.navigator.pose, action)
        return action

    def values(self, view: View) -> NDArray[np.float64]:
        """Return the weights of the unknown cells of a view, (H*W,); 0 for known ones."""
        if self._valued is None or self._valued[0] is not view.belief:
            self._valued = view.belief, unknown_weights(view.belief, self._weight)
        return self._valued[1]

    def on_the_way(self, view: View) -> NDArray[np.float64]:
        """Return the weights of unknown cells that a way may show, (H*W,)."""
        return unknown_weights(view.belief, UnknownWeight(0.0, self._policy.depth * self._range))

    def choose(self, view: View) -> Cell | None:
        """Return the cell of the pose that this UAV gets in its turn."""
        self.navigator.aim = self.chooser.choose_pose(view, self.navigator.pose)
        if self.navigator.aim is None:
            self._seen_from.clear()
            return None
        return self.navigator.aim.cell

    def is_spent(self, view: View, goal: Cell) -> bool:
        """Tell whether the sector of the goal shows nothing new, or this UAV has looked there."""
        pose = self.navigator.pose
        if pose is None or pose.heading == ANY:
            return super().is_spent(view, goal)
        if (view.cell, view.heading) == pose:
            self._seen_from.add(pose)
        return pose in self._seen_from or not shows_new(view.belief, pose.cell, pose.heading, self._camera)

    def poses(self, view: View, fields: Distances, starts: list[Pose]) -> Poses:
        """Return the best headings of the frontier clusters' cells, and the best poses near each UAV."""
        policy, belief = self._policy, view.belief
        facing = np.array([pose.heading for pose in starts])
        flat_starts = self.paths.flat(pose.cell for pose in starts)
        ahead = frontier_candidates(belief, fields, self._range, policy.clusters)
        nearby = np.flatnonzero((fields.reshape(len(fields), -1) <= policy.near).any(axis=0)).astype(np.int32)
        cells = np.repeat(np.concatenate([ahead, nearby]), HEADINGS)
        headings = np.tile(np.arange(HEADINGS), len(cells) // HEADINGS)
        gains = heading_gains(belief, cells[::HEADINGS], self.values(view), self._camera).ravel()
        gains *= ~self._looked(cells, headings)
        steps = pose_steps(fields, flat_starts, facing, cells, headings)
        worth = gains**policy.power * np.exp(-policy.discount_rate / self._range * np.minimum(steps, UNREACHABLE))
        worth = np.where(worth > 0.0, worth, np.where(gains > 0.0, 1e-300, 0.0))
        count = len(ahead) * HEADINGS
        best = np.argsort(-worth[:, :count].max(axis=0).reshape(-1, HEADINGS), axis=1, kind="stable")
        first = (np.arange(len(ahead)) * HEADINGS)[:, None] + best[:, : policy.headings]
        kept = np.zeros(len(cells), np.bool_)
        kept[first] = True
        for each in worth:
            near = np.argsort(-np.where(np.arange(len(cells)) < count, 0.0, each), kind="stable")[: policy.lookouts]
            kept[near] = True
        kept &= gains > 0.0
        standing = np.zeros(len(cells), np.bool_)
        standing[first[:, 0]] = True
        return Poses(cells[kept], headings[kept], standing[kept])

    def _looked(self, cells: NDArray[np.int32], headings: NDArray[np.int64]) -> Mask:
        """Return which of K poses this UAV has been in, (K,) bool."""
        been = [(cell[0] * self.paths.width + cell[1]) * HEADINGS + heading for cell, heading in self._seen_from]
        return np.isin(cells.astype(np.int64) * HEADINGS + headings, been)
