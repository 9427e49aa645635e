"""Frontier clusters in short joint sequences, weighed against the way through all that they leave behind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Distances, Mask
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.sensing.lidar import lidar_model
from indoor_explorers.planners.coordination.out_of_contact import OutOfContact
from indoor_explorers.planners.coordination.teammates import linked, message_of
from indoor_explorers.planners.frontier.group_pilot import GroupMember, member_of
from indoor_explorers.planners.information.candidates import (
    UnknownWeight,
    candidate_views,
    distances_between,
    frontier_candidates,
    local_candidates,
)
from indoor_explorers.planners.navigation.candidate_pilot import CandidatePilot
from indoor_explorers.planners.parameters import at_least
from indoor_explorers.planners.routing.sequences import DecisionProblem, Utility, best_sequences, cost_of_rest

#: Paths between places are measured up to this many lidar ranges; beyond this, the path length is bounded by going
#: through a UAV's position.
HOP_RANGES = 4.0
#: A cluster counts as seen from a place that shows this share of it.
SEEN = 0.5
#: A cluster belongs to teammates when its factor is less than this share of the largest factor.
THEIRS = 0.5
#: A place counts less when UAVs that chose before leave less than this share of its gain.
TAKEN = 0.25


@dataclass(frozen=True, kw_only=True)
class JointParameters:
    """How a :class:`JointPilot` weighs its candidates."""

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


@dataclass(frozen=True, kw_only=True)
class FrontierJoint(JointParameters, Policy):
    """Fly to the place with the best short sequence for the least cost of all that it leaves behind.

    Places are the frontier clusters, each at the cell nearest to the group, and a few cells near each UAV from which
    something unknown is in view. A sequence of up to three earns (gain left)^power e^(-rate t) trust^k for each: the
    discounted gain of H. H. Gonzalez-Banos, J.-C. Latombe, IJRR 2002, doi:10.1177/0278364902021010834, summed over an
    orienteering problem with a view counted once. That alone is greedy and leaves small pockets behind. So a place also
    costs what the best order of the UAV's own clusters costs that begins there, by the travelling repairman's measure
    (A. Blum et al., STOC 1994, doi:10.1145/195058.195125); the score is log(value) - order * cost.

    Linked UAVs take turns as in W. Burgard et al., IEEE T-RO 2005, doi:10.1109/TRO.2004.839232; what a sequence shows
    is worth less to those who choose later. Each works out all turns before its own, from the map, cells and goals that
    all of them know. What is left to teammates out of contact is :class:`OutOfContact`'s.
    """

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the mind of one UAV."""
        return JointPilot(briefing, self)


class JointPilot(CandidatePilot):
    """Choose in turn with the linked teammates, a few steps after the map has grown."""

    straight = True

    def __init__(self, briefing: Briefing, parameters: JointParameters) -> None:
        super().__init__(briefing)
        self._parameters = parameters
        self._range = float(briefing.lidar_range)
        self._utility = Utility(parameters.power, parameters.rate, parameters.trust)
        self._out_of_contact = OutOfContact(briefing)
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
        self._is_due, self._next_choice = False, view.step + max(1, round(self._parameters.period * self._range))
        own = GroupMember(self.briefing.agent, view.cell, self.goal)
        members = sorted([own, *map(member_of, linked(view))], key=lambda member: member.agent)
        me = members.index(own)
        problem = self.decision_problem(view, members)
        goal = None
        if (problem.away[me] < UNREACHABLE).any():
            goal = divmod(
                int(problem.cells[self.first(problem, me, self.factors(view, problem, me))]), self.paths.width
            )
        self.message = message_of(goal)
        return goal

    def first(self, problem: DecisionProblem, me: int, factors: NDArray[np.float64]) -> int:
        """Return which place UAV ``me`` flies to, when those with something better to do have taken their turns."""
        left, waiting = problem.gains, list(range(len(problem.away)))
        while True:
            alone = problem.hysteresis * left**self._parameters.power * np.exp(-self._parameters.rate * problem.away)
            turn = waiting.pop(int(alone[waiting].max(axis=1).argmax()))
            sequence = self.sequence(problem, turn, factors * left, factors)
            if turn == me:
                return int(sequence[0])
            taken = self._parameters.certainty ** np.arange(len(sequence))[sequence >= 0]
            left = left * np.prod(1.0 - taken * problem.shared[:, sequence[sequence >= 0]], axis=1)

    def sequence(
        self, problem: DecisionProblem, uav: int, gains: NDArray[np.float64], factors: NDArray[np.float64]
    ) -> NDArray[np.int64]:
        """Return the sequence that a UAV flies, (3,), -1 after its end, from the (K,) gains that are left."""
        parameters = self._parameters
        values, sequences = best_sequences(problem, uav, gains, self._utility)
        values = not_taken(values, gains, factors * problem.gains)
        if not values.any():
            return np.array([int(problem.away[uav].argmin()), -1, -1])
        best = np.argsort(-values, kind="stable")[: parameters.firsts]
        best = best[values[best] > 0.0]
        rest = self._own(problem, uav, gains, factors)
        costs = [self._cost(problem, uav, first, rest, gains) for first in best.tolist()]
        return np.asarray(sequences[best[np.argmax(np.log(values[best]) - parameters.order * np.array(costs))]])

    def decision_problem(self, view: View, members: list[GroupMember]) -> DecisionProblem:
        """Return what a group can choose from."""
        parameters, reach = self._parameters, self._range
        fields = np.stack([self.steps_from(view, member.cell) for member in members])
        cells, ahead = self.candidates(view, fields)
        fine = ~self.near_banned(view, cells)
        cells, ahead = cells[fine], ahead[fine]
        steps = fields.reshape(len(members), -1)[:, cells].astype(np.float64, order="C")
        gains, shared = candidate_views(
            view.belief, cells, UnknownWeight(parameters.isolation, parameters.fade * reach), lidar_model(reach)
        )
        between = distances_between(view.belief, cells, steps, int(HOP_RANGES * reach) + 1)
        hysteresis = np.stack([self.hysteresis_bonus(member.goal, cells, parameters.hold) for member in members])
        away = np.where(steps < UNREACHABLE, steps / reach, UNREACHABLE)
        return DecisionProblem(cells, ahead, away, between / reach, gains, shared, hysteresis)

    def candidates(self, view: View, fields: Distances) -> tuple[NDArray[np.int32], Mask]:
        """Return flat cells to choose from, (K,), and which of them stand for all that is left to see, (K,) bool.

        ``fields`` (N, H, W) are the steps of the UAVs of the group.
        """
        parameters, reach = self._parameters, self._range
        ahead = frontier_candidates(view.belief, fields, reach, parameters.clusters)
        around = local_candidates(
            view.belief, fields, reach, parameters.near, parameters.rate / reach, parameters.lookouts
        )
        around = np.setdiff1d(around, np.concatenate([ahead, self.paths.flat(self.visited)]))
        cells = np.concatenate([ahead, around]).astype(np.int32)
        return cells, np.arange(len(cells)) < len(ahead)

    def factors(self, view: View, problem: DecisionProblem, me: int) -> NDArray[np.float64]:
        """Return what teammates out of contact leave of each of K places, (K,)."""
        if self.briefing.team == 1:
            return np.ones(len(problem.cells))
        points = np.stack(np.divmod(problem.cells, self.paths.width), axis=1).astype(np.float64)
        steps = self.steps_from(view, view.cell).ravel()[problem.cells]
        return self._out_of_contact.factors(
            view, points, steps, lambda cell: self.steps_from(view, cell).ravel()[problem.cells]
        )

    def _own(
        self, problem: DecisionProblem, uav: int, gains: NDArray[np.float64], factors: NDArray[np.float64]
    ) -> NDArray[np.int64]:
        """Return the numbers of the clusters that no teammate is nearer to, those worth most now."""
        nearest = (problem.away[uav] < UNREACHABLE) & (problem.away[uav] <= problem.away.min(axis=0))
        own = np.flatnonzero(problem.ahead & nearest & (factors >= THEIRS * factors.max()))
        worth = gains[own] ** self._parameters.power * np.exp(-self._parameters.rate * problem.away[uav, own])
        return np.asarray(own[np.argsort(-worth, kind="stable")[: self._parameters.rest]])

    def _cost(
        self, problem: DecisionProblem, uav: int, first: int, rest: NDArray[np.int64], gains: NDArray[np.float64]
    ) -> float:
        """Return what it costs to begin with a place and go on with what that does not show."""
        left = gains * (1.0 - problem.shared[:, first])
        left[first] = gains[first]
        rest = rest[(rest != first) & (problem.shared[rest, first] < SEEN)]
        return cost_of_rest(problem, uav, first, rest, left**self._parameters.power, self._parameters.latency)


def not_taken(
    values: NDArray[np.float64], left: NDArray[np.float64], gains: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return what (K,) first places are worth, the less the more of them linked teammates have taken.

    Without this, a UAV flies towards what it likes best by way of a teammate's place, and so in its wake. Where
    nothing is left of any, values are as they were.
    """
    free = values * np.minimum(1.0, left / np.maximum(TAKEN * gains, 1e-300))
    return free if free.any() else values
