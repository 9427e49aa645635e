"""PSO: a linked group optimises a joint plan of several goals for each UAV."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Distances
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.swarm.assignment import (
    Assignment,
    AssignmentProblem,
    Plan,
    by_greed,
    by_hungarian,
    by_minpos,
    reachable_or_nearest,
)
from indoor_explorers.planners.swarm.particles import optimise
from indoor_explorers.planners.toolbox.coordination.linked_group import (
    NOWHERE,
    LinkedMember,
    absentees,
    linked_members,
    plan_message,
)
from indoor_explorers.planners.toolbox.coordination.out_of_contact import OutOfContact
from indoor_explorers.planners.toolbox.information.candidates import (
    Cells,
    Table,
    UnknownWeight,
    candidate_views,
    distances_between,
    frontier_candidates,
    local_candidates,
)
from indoor_explorers.planners.toolbox.navigation.candidate_pilot import CandidatePilot
from indoor_explorers.planners.toolbox.parameters import (
    DiscountParameters,
    GainParameters,
    GoalBonusParameters,
    ReplanParameters,
    bounded,
)

#: Paths between candidates are searched up to this length, in lidar ranges.
HOP_RANGES = 1.5


@renamed(fade="decay_length", rate="discount_rate", hold="goal_bonus")
@dataclass(frozen=True, kw_only=True)
class Pso(GainParameters, DiscountParameters, GoalBonusParameters, ReplanParameters, Policy):
    """Assign several goals to each UAV of the linked group by a particle swarm over joint plans.

    The fitness of a plan is the union of all views of the group, each discounted by its time of arrival; isolated
    unknown cells have more weight, and those deep inside unknown space less. Linked UAVs have the same map and know
    each other's cells and messages, so each computes the same plan, from a random seed made of common knowledge, and
    flies to the first of its own goals. They plan at the same time: when a goal has no gain left, when two UAVs with
    different plans meet, and every few steps if the map has grown; the current goals then get a bonus.

    The swarm starts from four initial plans: greedy, Hungarian, MinPos and the current goals; its result is never
    worse. The search improves the fitness of teams over the best initial plan, but hardly the steps
    (``indoor-explorers compare --experiment evaluation/experiments/pso-search.toml --out results/pso-search``, T99 of
    60 episodes with 95 % intervals): in ``thesis-obstacles`` 62.5 [59.9, 65.2] against 62.3 [60.1, 64.6], with four
    UAVs in ``thesis-team-4`` 20.3 [19.1, 21.6] against 20.5 [19.2, 21.8]; ``frontier-minpos`` needs 70.4 and 27.5. So
    the fitness makes the difference, not the search. Weaknesses: mazes and small rooms with little radio, where the
    nearest pocket is the best goal.

    The swarm: J. Kennedy, R. Eberhart, ICNN 1995, doi:10.1109/ICNN.1995.488968. The fitness is this project's.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    particles: int = bounded(20, least=1)
    """Particles of the swarm, including the four that start from the initial plans."""
    rounds: int = bounded(30, least=0)
    """Most iterations of the swarm; with 0 and one particle the best initial plan is flown."""
    length: int = bounded(3, least=1, tunable=(1, 5))
    """Goals of a UAV in a plan; the UAV flies to the first one."""
    power: float = bounded(0.5, least=0, tunable=(0.1, 1.5))
    """Exponent of the view gain: 1 leaves small pockets behind for larger views, 0 prefers the nearest goal."""
    trust: float = bounded(0.5, least=0, tunable=(0.1, 1.0))
    """Factor for every goal that a UAV visits before, since the map may differ from expectation, 0 to 1."""
    decay_length: float = bounded(0.5, least=1e-6, tunable=(0.1, 2.0, "log"))
    """Depth inside unknown space over which the weight of an unknown cell falls to 1 / e, in lidar ranges."""
    absence: float = bounded(0.5, least=0, tunable=(0.0, 1.0))
    """Share of its value that a goal loses if a teammate out of contact was last known closer to it, 0 to 1."""
    sector: float = bounded(3.0, least=0, tunable=(0.0, 6.0))
    """Preference of a UAV alone for its sector while teammates were never heard; see :class:`OutOfContact`."""
    period: float = 0.2
    """Steps after which the group plans again if the map has grown, in lidar ranges."""
    candidates: int = bounded(32, least=1)
    """Most frontier clusters to choose from: the nearest to any UAV of the group."""
    lookouts: int = bounded(8, least=0, tunable=(0, 16))
    """Most other candidates near each UAV, cells with unknown cells in view."""
    near: int = bounded(6, least=0, tunable=(2, 12))
    """Largest distance of these from a UAV, in steps."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return PsoPilot(briefing, self)


class JointPlan(NamedTuple):
    """A joint plan of N UAVs, and its inputs."""

    problem: AssignmentProblem
    cells: Assignment
    """(K,) flat cells of the candidates."""
    members: list[LinkedMember]
    """The N UAVs."""
    initial: list[Assignment]
    """First goals of the initial plans, (N,) each: greedy, Hungarian, MinPos and the current goals."""
    best: Plan
    """(N, L)."""


class PsoPilot(CandidatePilot):
    """Take part in the joint plans of the linked group."""

    changes_levels: ClassVar[bool] = True

    def __init__(self, briefing: Briefing, policy: Pso) -> None:
        super().__init__(briefing)
        self._policy = policy
        self._range = float(briefing.lidar_range)
        self._out_of_contact = OutOfContact(briefing, sector=policy.sector)
        self._period = self.steps_in(policy.period)
        self._plan: tuple[float, ...] = NOWHERE
        self._planned_on = -1

    def act(self, view: View) -> int:
        """Follow the joint plan and send it to the others."""
        action = super().act(view)
        self.message = plan_message(view, self.briefing, self.goal, self._plan)
        return action

    def wants_replan(self, view: View) -> bool:
        """Tell whether linked UAVs have different plans, one of their goals has no gain left, or the plan is old."""
        if self.navigator.stamp != self._planned_on and view.step - self._plan[0] >= self._period:
            return True
        if not any(mate.age == 0 for mate in view.mates):
            return False
        members = [member for member in self.members(view) if member.goal]
        return any(member.plan != self._plan for member in members) or any(
            self.is_spent(view, member.goal) for member in members if member.goal
        )

    def choose(self, view: View) -> Cell | None:
        """Return this UAV's goal in the joint plan, or its nearest frontier cell if it has none."""
        members = self.members(view)
        self._plan = (float(view.step), float(members[0].agent))
        self._planned_on = self.navigator.stamp
        goal = self.plan(view, members).get(self.briefing.agent)
        if goal is None or goal in self.visited or self.near_banned(view, self.paths.flat([goal])).any():
            goal = self.nearest_frontier(view)
        return goal

    def members(self, view: View) -> list[LinkedMember]:
        """Return the members of the linked group, by number."""
        return linked_members(view, self.briefing, self.message)

    def plan(self, view: View, members: list[LinkedMember]) -> dict[int, Cell]:
        """Return the next goal of every UAV of the group that can reach a candidate, by number.

        Every member computes the same plan from common knowledge.
        """
        joint = self.joint_plan(view, members)
        if joint is None:
            return {}
        first: Assignment = joint.cells[joint.best[:, 0]]
        self._consider(joint)
        return {
            member.agent: divmod(int(cell), self.paths.width) for member, cell in zip(joint.members, first, strict=True)
        }

    def _consider(self, joint: JointPlan) -> None:
        """Keep the candidates with their values to this UAV alone; the joint plan has the largest sum."""
        me = next((k for k, member in enumerate(joint.members) if member.agent == self.briefing.agent), None)
        if self.explaining and me is not None:
            problem = joint.problem
            steps = problem.steps[me]
            alone = problem.hysteresis[me] * problem.gains**problem.power * np.exp(-problem.rate * steps)
            self.consider(
                joint.cells,
                "value to this UAV alone; the group's best sum counts",
                alone,
                gain=problem.gains,
                steps=steps,
            )

    def joint_plan(self, view: View, members: list[LinkedMember]) -> JointPlan | None:
        """Return the joint plan of the members that can reach a candidate; None if no member can."""
        problem, cells, able = self.decision_problem(view, members)
        if problem is None:
            return None
        held = np.where(problem.hysteresis.max(axis=1) > 1, problem.hysteresis.argmax(axis=1), -1)
        seeds = [by_greed(problem), by_hungarian(problem), by_minpos(problem), reachable_or_nearest(problem, held)]
        shared = np.random.default_rng([view.step, *self.paths.flat(member.cell for member in able).tolist()])
        return JointPlan(problem, cells, able, seeds, self.search(problem, seeds, shared))

    def search(self, problem: AssignmentProblem, seeds: list[Assignment], rng: np.random.Generator) -> Plan:
        """Return the best joint plan that a search from the initial assignments finds, (N, L)."""
        policy = self._policy
        return optimise(problem, policy.length, seeds, policy.particles, policy.rounds, rng)

    def chances(self, view: View, cells: Cells, field: Distances) -> NDArray[np.float64]:
        """Return factors on the gains of (K,) flat cells by their outlook, (K,); cells with 0 are deferred.

        ``field`` (H, W) are the steps from the nearest UAV of the group. Here, all factors are 1.
        """
        return np.ones(len(cells))

    def decision_problem(
        self, view: View, members: list[LinkedMember]
    ) -> tuple[AssignmentProblem | None, Assignment, list[LinkedMember]]:
        """Return the group's decision problem, the flat cells of its candidates, and the members that can reach one.

        The problem is None if no member can.
        """
        policy, reach = self._policy, self._range
        fields = np.stack([self.steps_from(view, member.cell) for member in members])
        cells = self._candidates(view, fields)
        chances = self.chances(view, cells, fields.min(axis=0))
        cells, chances = cells[chances > 0.0], chances[chances > 0.0]
        steps = fields.reshape(len(members), -1)[:, cells].astype(np.float64)
        can = np.asarray((steps < UNREACHABLE).any(axis=1))
        if not can.any():
            return None, cells.astype(np.int64), []
        steps, able = steps[can], [member for member, some in zip(members, can.tolist(), strict=True) if some]
        gains, shared = candidate_views(
            view.belief, cells, UnknownWeight(policy.isolation, policy.decay_length * reach), self.lidar
        )
        problem = AssignmentProblem(
            steps=steps,
            hops=distances_between(view.belief, cells, steps, int(HOP_RANGES * reach) + 1, self.paths.rise),
            gains=gains * chances * self._left_by_others(view, members, cells, steps),
            shared=shared,
            hysteresis=np.stack([self.hysteresis_bonus(member.goal, cells, policy.goal_bonus) for member in able]),
            power=policy.power,
            rate=policy.discount_rate / reach,
            trust=policy.trust,
            lidar_range=reach,
        )
        return problem, cells.astype(np.int64), able

    def _candidates(self, view: View, fields: Distances) -> Cells:
        policy, reach = self._policy, self._range
        around = local_candidates(
            view.belief, fields, self.lidar, policy.near, policy.discount_rate / reach, policy.lookouts
        )
        ahead = frontier_candidates(view.belief, fields, reach, policy.candidates, self.paths.rise)
        return np.union1d(ahead, around).astype(np.int32)

    def _left_by_others(self, view: View, members: list[LinkedMember], cells: Cells, steps: Table) -> Table:
        """Return the factors on K candidates, (N, K) steps away, for teammates out of contact with the group, (K,).

        Members may have heard of different teammates, so sectors count only for a UAV that is alone.
        """
        left = self._out_of_contact.left_by_unheard_at_cells(view, cells)
        if len(members) > 1:
            left = np.ones(len(cells))
        for mate in absentees(members, self.briefing):
            away = self.steps_from(view, mate.cell).ravel()[cells]
            left = np.where(away < steps.min(axis=0), (1.0 - self._policy.absence) * left, left)
        return left
