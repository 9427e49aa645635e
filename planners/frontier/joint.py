"""Frontier clusters in short joint sequences, weighed against the way through all that they leave behind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Distances, Mask
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.sensing.lidar import optics
from indoor_explorers.planners.coordination.out_of_contact import Unlinked
from indoor_explorers.planners.coordination.teammates import linked, message_of
from indoor_explorers.planners.frontier.group_pilot import Member, member_of
from indoor_explorers.planners.information.candidates import Interest, frontiers, hops, surroundings, views
from indoor_explorers.planners.navigation.candidate_pilot import CandidatePilot
from indoor_explorers.planners.parameters import at_least
from indoor_explorers.planners.routing.sequences import Task, Worth, best_sequences, cost_of_rest

#: Paths between places are measured up to so many lidar ranges; farther ones lead past a UAV.
HOP_RANGES = 4.0
#: A cluster of which a place shows this share is no longer among what is left behind.
SEEN = 0.5
#: A cluster of which teammates leave less than this share of the most is theirs.
THEIRS = 0.5
#: A place of which those who have chosen before leave less than this share is taken, the more so the less they leave.
TAKEN = 0.25


@dataclass(frozen=True, kw_only=True)
class FrontierJoint(Policy):
    """Fly to the place with the best short sequence for the least cost of all that it leaves behind.

    Places are the frontier clusters, each at the cell nearest to the group, and a few cells near each UAV from which
    something unknown is in view. A sequence of up to three earns (gain left)^power e^(-rate t) trust^k for each: the
    discounted gain of H. H. Gonzalez-Banos, J.-C. Latombe, IJRR 2002, doi:10.1177/0278364902021010834, summed over an
    orienteering problem with a view counted once. That alone is greedy and leaves small pockets behind. So a place also
    costs what the best order of the UAV's own clusters costs that begins there, by the travelling repairman's measure
    (A. Blum et al., STOC 1994, doi:10.1145/195058.195125); the score is log(value) - order * cost.

    Linked UAVs take turns as in W. Burgard et al., IEEE T-RO 2005, doi:10.1109/TRO.2004.839232; what a sequence shows
    is worth less to those who choose later. Each works out all turns before its own, from the map, cells and goals that
    all of them know. What is left to teammates out of contact is :class:`Unlinked`'s.
    """

    isolation: float = 8.0
    """Extra weight of an unknown cell whose 5x5 is known otherwise; finishes pockets while near."""
    fade: float = 0.5
    """Depth inside the unknown at which a cell counts 1 / e, in lidar ranges."""
    power: float = 0.5
    """Exponent of what is in view: 1 leaves small pockets behind for ever larger views, 0 flies to what is near."""
    rate: float = 0.8
    """How fast a view loses its value with the time of arrival, per lidar range."""
    trust: float = 0.5
    """Factor for every place that a UAV visits before, as the map may turn out otherwise, 0 to 1."""
    order: float = 1.0
    """What a lidar range of the cost of all clusters takes off the logarithm of a sequence's value."""
    latency: float = 3.0
    """Weight of the mean waiting time beside the length in that cost."""
    hold: float = 0.2
    """Extra value of a place that is near the goal that a UAV has."""
    certainty: float = 0.5
    """Share in which a linked teammate's second place counts as seen by it, its third by the square; 0 to 1."""
    period: float = 0.1
    """Steps after which a UAV chooses again if the map has grown, in lidar ranges."""
    clusters: int = 32
    """The most frontier clusters to choose from: the nearest to any UAV of the group."""
    lookouts: int = 8
    """The most other cells near each UAV to choose from."""
    near: int = 6
    """How near these are, in steps."""
    firsts: int = 8
    """The places with the best sequences, for which the cost of the rest is found."""
    rest: int = 12
    """The most clusters in that cost: the UAV's own that are worth most to it now."""

    def __post_init__(self) -> None:
        at_least(self, 0.0, "isolation", "power", "rate", "trust", "order", "latency", "hold", "certainty", "period")
        at_least(self, 0.0, "lookouts", "near", "rest")
        at_least(self, 1e-6, "fade")
        at_least(self, 1, "clusters", "firsts")

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the mind of one UAV."""
        return JointPilot(briefing, self)


class JointPilot(CandidatePilot):
    """Choose in turn with whoever is linked, a few steps after the map has grown."""

    straight = True

    def __init__(self, briefing: Briefing, policy: FrontierJoint) -> None:
        super().__init__(briefing)
        self._policy = policy
        self._range = float(briefing.lidar_range)
        self._worth = Worth(policy.power, policy.rate, policy.trust)
        self._unlinked = Unlinked(briefing)
        self._is_due = True
        self._next_choice = 0

    def on_map_growth(self, view: View) -> None:
        """Ask for a choice, as the map has grown."""
        self._is_due = True

    def wants_replan(self, view: View) -> bool:
        """Tell whether the map has grown since the last choice and that was some steps ago."""
        return self._is_due and view.step >= self._next_choice

    def choose(self, view: View) -> Cell | None:
        """Return the place that is left for this UAV when its turn comes."""
        self._is_due, self._next_choice = False, view.step + max(1, round(self._policy.period * self._range))
        own = Member(self.briefing.agent, view.cell, self.goal)
        members = sorted([own, *map(member_of, linked(view))], key=lambda member: member.agent)
        me = members.index(own)
        task = self.task(view, members)
        goal = None
        if (task.away[me] < UNREACHABLE).any():
            goal = divmod(int(task.cells[self.first(task, me, self.factors(view, task, me))]), self.paths.width)
        self.message = message_of(goal)
        return goal

    def first(self, task: Task, me: int, factors: NDArray[np.float64]) -> int:
        """Return which place UAV ``me`` flies to, when those with something better to do have taken their turns."""
        left, waiting = task.gains, list(range(len(task.away)))
        while True:
            alone = task.favour * left**self._policy.power * np.exp(-self._policy.rate * task.away)
            turn = waiting.pop(int(alone[waiting].max(axis=1).argmax()))
            sequence = self.sequence(task, turn, factors * left, factors)
            if turn == me:
                return int(sequence[0])
            taken = self._policy.certainty ** np.arange(len(sequence))[sequence >= 0]
            left = left * np.prod(1.0 - taken * task.shared[:, sequence[sequence >= 0]], axis=1)

    def sequence(
        self, task: Task, uav: int, gains: NDArray[np.float64], factors: NDArray[np.float64]
    ) -> NDArray[np.int64]:
        """Return the sequence that a UAV flies, (3,), -1 after its end, from the (K,) gains that are left."""
        policy = self._policy
        values, sequences = best_sequences(task, uav, gains, self._worth)
        values = not_taken(values, gains, factors * task.gains)
        if not values.any():
            return np.array([int(task.away[uav].argmin()), -1, -1])
        best = np.argsort(-values, kind="stable")[: policy.firsts]
        best = best[values[best] > 0.0]
        rest = self._own(task, uav, gains, factors)
        costs = [self._cost(task, uav, first, rest, gains) for first in best.tolist()]
        return np.asarray(sequences[best[np.argmax(np.log(values[best]) - policy.order * np.array(costs))]])

    def task(self, view: View, members: list[Member]) -> Task:
        """Return what a group can choose from."""
        policy, reach = self._policy, self._range
        fields = np.stack([self.steps_from(view, member.cell) for member in members])
        cells, ahead = self.places(view, fields)
        fine = ~self.near_banned(view, cells)
        cells, ahead = cells[fine], ahead[fine]
        steps = fields.reshape(len(members), -1)[:, cells].astype(np.float64)
        gains, shared = views(view.belief, cells, Interest(policy.isolation, policy.fade * reach), optics(reach))
        between = hops(view.belief, cells, steps, int(HOP_RANGES * reach) + 1)
        favour = np.stack([self.hysteresis_bonus(member.goal, cells, policy.hold) for member in members])
        away = np.where(steps < UNREACHABLE, steps / reach, UNREACHABLE)
        return Task(cells, ahead, away, between / reach, gains, shared, favour)

    def places(self, view: View, fields: Distances) -> tuple[NDArray[np.int32], Mask]:
        """Return flat cells to choose from, (K,), and which of them stand for all that is left to see, (K,) bool.

        ``fields`` (N, H, W) are the steps of the UAVs of the group.
        """
        policy, reach = self._policy, self._range
        ahead = frontiers(view.belief, fields, reach, policy.clusters)
        around = surroundings(view.belief, fields, reach, policy.near, policy.rate / reach, policy.lookouts)
        around = np.setdiff1d(around, np.concatenate([ahead, self.paths.flat(self.visited)]))
        cells = np.concatenate([ahead, around]).astype(np.int32)
        return cells, np.arange(len(cells)) < len(ahead)

    def factors(self, view: View, task: Task, me: int) -> NDArray[np.float64]:
        """Return what teammates out of contact leave of each of K places, (K,)."""
        if self.briefing.team == 1:
            return np.ones(len(task.cells))
        points = np.stack(np.divmod(task.cells, self.paths.width), axis=1).astype(np.float64)
        steps = self.steps_from(view, view.cell).ravel()[task.cells]
        return self._unlinked.factors(view, points, steps, lambda cell: self.steps_from(view, cell).ravel()[task.cells])

    def _own(self, task: Task, uav: int, gains: NDArray[np.float64], factors: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the numbers of the clusters that no teammate is nearer to, those worth most now."""
        nearest = (task.away[uav] < UNREACHABLE) & (task.away[uav] <= task.away.min(axis=0))
        own = np.flatnonzero(task.ahead & nearest & (factors >= THEIRS * factors.max()))
        worth = gains[own] ** self._policy.power * np.exp(-self._policy.rate * task.away[uav, own])
        return np.asarray(own[np.argsort(-worth, kind="stable")[: self._policy.rest]])

    def _cost(self, task: Task, uav: int, first: int, rest: NDArray[np.int64], gains: NDArray[np.float64]) -> float:
        """Return what it costs to begin with a place and go on with what that does not show."""
        left = gains * (1.0 - task.shared[:, first])
        left[first] = gains[first]
        rest = rest[(rest != first) & (task.shared[rest, first] < SEEN)]
        return cost_of_rest(task, uav, first, rest, left**self._policy.power, self._policy.latency)


def not_taken(
    values: NDArray[np.float64], left: NDArray[np.float64], gains: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return what (K,) first places are worth, the less the more of them linked teammates have taken.

    Without this, a UAV flies towards what it likes best by way of a teammate's place, and so in its wake. Where
    nothing is left of any, values are as they were.
    """
    free = values * np.minimum(1.0, left / np.maximum(TAKEN * gains, 1e-300))
    return free if free.any() else values
