"""The choice of a candidate by the best short sequence that begins there, in turn with the linked teammates.

A pilot has a :class:`SequenceChooser` and gives it the candidates. The score of a candidate is the logarithm of the
value of its best sequence, minus the cost of the clusters that remain
(:mod:`indoor_explorers.planners.toolbox.routing.sequences`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Distances, Mask
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.view import View
from indoor_explorers.planners.toolbox.coordination.out_of_contact import OutOfContact
from indoor_explorers.planners.toolbox.information.candidates import UnknownWeight, candidate_views, distances_between
from indoor_explorers.planners.toolbox.navigation.candidate_pilot import CandidatePilot
from indoor_explorers.planners.toolbox.navigation.teammates import GroupMember, group_of, linked
from indoor_explorers.planners.toolbox.parameters import (
    DiscountParameters,
    GainParameters,
    GoalBonusParameters,
    bounded,
)
from indoor_explorers.planners.toolbox.routing.sequences import DecisionProblem, Utility, best_sequences, cost_of_rest

#: Paths between candidates are searched up to this length in lidar ranges; longer ones are replaced by the path through
#: a UAV's cell.
HOP_RANGES = 4.0
#: Share of a cluster that must be in view of a candidate for the cluster to count as seen from there.
SEEN = 0.5
#: A cluster is left to teammates if its factor is less than this share of the largest factor.
THEIRS = 0.5
#: Share of a candidate's gain below which the candidate has less value, after the choices of other UAVs.
TAKEN = 0.25

#: What the scores are.
SCORE = "log of the value of the best sequence, less the cost of the order of the rest"

#: Returns flat candidate cells, (K,), and which of them are frontier clusters, (K,) bool, from a view and the steps
#: from the UAVs of the group, (N, H, W).
Candidates = Callable[[View, Distances], tuple[NDArray[np.int32], Mask]]


@dataclass(frozen=True, kw_only=True)
class SequenceParameters(GainParameters, DiscountParameters, GoalBonusParameters):
    """Parameters by which a :class:`SequenceChooser` compares candidates."""

    decay_length: float = bounded(0.5, least=1e-6, tunable=(0.1, 2.0, "log"))
    """Depth inside unknown space over which the weight of an unknown cell falls to 1 / e, in lidar ranges."""
    power: float = bounded(0.5, least=0, tunable=(0.1, 1.5))
    """Exponent of the view gain: 1 leaves small pockets behind for larger views, 0 prefers the nearest candidate."""
    trust: float = bounded(0.5, least=0, tunable=(0.1, 1.0))
    """Factor for every candidate that a UAV visits before, since the map may differ from expectation, 0 to 1."""
    order: float = bounded(1.0, least=0, tunable=(0.1, 4.0, "log"))
    """Weight of the cost of all clusters, per lidar range, against the logarithm of a sequence's value."""
    latency: float = bounded(3.0, least=0, tunable=(0.3, 30.0, "log"))
    """Weight of the mean waiting time relative to the length in that cost."""
    certainty: float = bounded(0.5, least=0, tunable=(0.0, 1.0))
    """Share of the view from a linked teammate's second candidate that counts as seen; of its third one, the square."""
    firsts: int = bounded(8, least=1)
    """Number of candidates with the best sequences for which the cost of the rest is computed."""
    rest: int = bounded(12, least=0)
    """Most clusters in that cost: those of the UAV's own clusters with the largest discounted gains."""


class SequenceChooser:
    """Choose the candidate that a UAV gets in its turn.

    Linked UAVs choose one after the other, the one with the best choice first; cells in view of a sequence are worth
    less to UAVs that choose later. Each UAV computes all turns before its own, from the map, cells and goals that all
    of them know.

    Args:
        pilot: The pilot that flies to the candidates.
        parameters: How candidates are compared.
        candidates: Returns the candidates of a decision.

    """

    def __init__(self, pilot: CandidatePilot, parameters: SequenceParameters, candidates: Candidates) -> None:
        self._pilot, self.parameters, self.candidates = pilot, parameters, candidates
        self._range = float(pilot.briefing.lidar_range)
        self._utility = Utility(parameters.power, parameters.discount_rate, parameters.trust)
        self.out_of_contact = OutOfContact(pilot.briefing)
        """The factors for teammates out of contact."""

    def choose(self, view: View) -> Cell | None:
        """Return the candidate that this UAV gets; None if it can reach none."""
        members = self.members(view)
        me = next(k for k, member in enumerate(members) if member.agent == self._pilot.briefing.agent)
        problem = self.decision_problem(view, members)
        if not (problem.away[me] < UNREACHABLE).any():
            return None
        candidate = self.first(problem, me, self.factors(view, problem, me))
        return divmod(int(problem.cells[candidate]), self._pilot.paths.width)

    def members(self, view: View) -> list[GroupMember]:
        """Return this UAV and its linked teammates, by number."""
        return group_of(GroupMember(self._pilot.briefing.agent, view.cell, self._pilot.goal), linked(view))

    def first(self, problem: DecisionProblem, me: int, factors: NDArray[np.float64]) -> int:
        """Return the index of the candidate that UAV ``me`` gets, after the turns of all UAVs with a better choice.

        ``factors`` (K,) are the candidates' factors for teammates out of contact.
        """
        parameters, left, waiting = self.parameters, problem.gains, list(range(len(problem.away)))
        while True:
            alone = problem.hysteresis * left**parameters.power * np.exp(-parameters.discount_rate * problem.away)
            turn = waiting.pop(int(alone[waiting].max(axis=1).argmax()))
            sequence = self.sequence(problem, turn, factors * left, factors)
            if turn == me:
                return int(sequence[0])
            taken = parameters.certainty ** np.arange(len(sequence))[sequence >= 0]
            left = left * np.prod(1.0 - taken * problem.shared[:, sequence[sequence >= 0]], axis=1)

    def sequence(
        self, problem: DecisionProblem, uav: int, gains: NDArray[np.float64], factors: NDArray[np.float64]
    ) -> NDArray[np.int64]:
        """Return a UAV's sequence, (3,) indices, -1 after its end, for the remaining (K,) ``gains``."""
        parameters = self.parameters
        values, sequences = best_sequences(problem, uav, gains, self._utility)
        values = not_taken(values, gains, factors * problem.gains)
        if not values.any():
            self._pilot.consider(problem.cells[:0], SCORE, np.empty(0))
            return np.array([int(problem.away[uav].argmin()), -1, -1])
        best = np.argsort(-values, kind="stable")[: parameters.firsts]
        best = best[values[best] > 0.0]
        rest = self._own(problem, uav, gains, factors)
        costs = np.array([self._cost(problem, uav, first, rest, gains) for first in best.tolist()])
        scores = np.log(values[best]) - parameters.order * costs
        steps = problem.away[uav, best] * self._range
        self._pilot.consider(
            problem.cells[best], SCORE, scores, value=values[best], order=costs, gain=gains[best], steps=steps
        )
        return np.asarray(sequences[best[np.argmax(scores)]])

    def decision_problem(self, view: View, members: list[GroupMember]) -> DecisionProblem:
        """Return the decision problem of a group."""
        parameters, reach = self.parameters, self._range
        fields = np.stack([self._pilot.steps_from(view, member.cell) for member in members])
        cells, ahead = self.candidates(view, fields)
        fine = ~self._pilot.near_banned(view, cells)
        cells, ahead = cells[fine], ahead[fine]
        steps = fields.reshape(len(members), -1)[:, cells].astype(np.float64, order="C")
        gains, shared = candidate_views(
            view.belief, cells, UnknownWeight(parameters.isolation, parameters.decay_length * reach), self._pilot.lidar
        )
        between = distances_between(view.belief, cells, steps, int(HOP_RANGES * reach) + 1, self._pilot.paths.rise)
        bonus = self._pilot.hysteresis_bonus
        hysteresis = np.stack([bonus(member.goal, cells, parameters.goal_bonus) for member in members])
        away = np.where(steps < UNREACHABLE, steps / reach, UNREACHABLE)
        return DecisionProblem(cells, ahead, away, between / reach, gains, shared, hysteresis)

    def factors(self, view: View, problem: DecisionProblem, me: int) -> NDArray[np.float64]:
        """Return the factors of K candidates for teammates out of contact, (K,)."""
        if self._pilot.briefing.team == 1:
            return np.ones(len(problem.cells))
        steps = self._pilot.steps_from(view, view.cell).ravel()[problem.cells]
        return self.out_of_contact.at_cells(view, problem.cells, steps, self._pilot.steps_from)

    def _own(
        self, problem: DecisionProblem, uav: int, gains: NDArray[np.float64], factors: NDArray[np.float64]
    ) -> NDArray[np.int64]:
        """Return the indices of clusters that no teammate is closer to: those with the largest discounted gains."""
        nearest = (problem.away[uav] < UNREACHABLE) & (problem.away[uav] <= problem.away.min(axis=0))
        own = np.flatnonzero(problem.ahead & nearest & (factors >= THEIRS * factors.max()))
        worth = gains[own] ** self.parameters.power * np.exp(-self.parameters.discount_rate * problem.away[uav, own])
        return np.asarray(own[np.argsort(-worth, kind="stable")[: self.parameters.rest]])

    def _cost(
        self, problem: DecisionProblem, uav: int, first: int, rest: NDArray[np.int64], gains: NDArray[np.float64]
    ) -> float:
        """Return the cost of the best order that begins with a candidate, through the clusters not seen from there."""
        left = gains * (1.0 - problem.shared[:, first])
        left[first] = gains[first]
        rest = rest[(rest != first) & (problem.shared[rest, first] < SEEN)]
        return cost_of_rest(problem, uav, first, rest, left**self.parameters.power, self.parameters.latency)


def not_taken(
    values: NDArray[np.float64], left: NDArray[np.float64], gains: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the values of (K,) first candidates, reduced by the share of their gain that linked teammates have taken.

    Without this, a UAV flies to its best candidate by way of a teammate's, and so follows the teammate. If no candidate
    has any gain left, the values are unchanged.
    """
    free = values * np.minimum(1.0, left / np.maximum(TAKEN * gains, 1e-300))
    return free if free.any() else values
