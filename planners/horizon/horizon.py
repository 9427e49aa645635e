"""Receding horizon: plan the whole remaining tour, fly its first step, plan again when the map has grown."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError, shown
from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.grid.levels import action_between
from indoor_explorers.env.maps.generators.thesis import ThesisMaps
from indoor_explorers.env.policies.explanation import Explanation
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.frontier.joint import FrontierJoint
from indoor_explorers.planners.horizon.beam import BeamConfig
from indoor_explorers.planners.horizon.learned_prior import LearnedPrior, OpenPrior, Prior
from indoor_explorers.planners.horizon.rollout_choice import RolloutSelection
from indoor_explorers.planners.horizon.room_prior import RoomPrior
from indoor_explorers.planners.horizon.tour_planner import TourPlanner
from indoor_explorers.planners.toolbox.navigation.deadlock import DeadlockResolver
from indoor_explorers.planners.toolbox.navigation.paths import Paths, map_stamp
from indoor_explorers.planners.toolbox.navigation.teammates import remembered
from indoor_explorers.planners.toolbox.parameters import Parameters, bounded, one_of

#: If the goal leaves cells out, isolation matters less: its weight halves with each such share of the coverage.
GOAL_SCALE = 0.05
#: A tour without a gain for its length plus this many steps is given up until the map grows.
PATIENCE = 8

#: Where the probability of obstacles comes from.
PriorSource = Literal["source", "belief", "none"]


@dataclass(frozen=True, kw_only=True)
class Horizon(Parameters, Policy):
    """Plan a tour of all unseen cells by beam search and keep it while it is valid; on large maps, fly to frontiers.

    In rooms of up to ``room`` cells the search is over (cell, unseen set) and assumes that unknown cells are free and
    transparent. It aims at the scenario's goal coverage. Cells are weighted by their probability to be free: with
    ``prior`` "source" and a generator of random rooms, the probability is computed from the generator's statistics
    (``briefing.generator``: number, sizes and margins of obstacles; never the map); otherwise, and with "belief", it is
    learned during the flight from the UAV's own map. On larger maps, on those of several levels, or if no tour is
    found, ``beyond`` plans a few frontiers ahead instead.

    Receding-horizon exploration: A. Bircher et al., ICRA 2016, doi:10.1109/ICRA.2016.7487281; the search over whole
    tours is this project's.
    """

    uses_generator: ClassVar[bool] = True
    plans_for: ClassVar[str] = "the scenario's goal in rooms, all cells elsewhere"

    width: int = bounded(100, least=1)
    """Beam width: states kept at each step."""
    depth: int = bounded(80, least=1)
    """Search depth in steps."""
    isolation: float = bounded(8.0, least=0, tunable=(1.0, 32.0, "log"))
    """Additional weight of an unseen cell without unseen neighbours, in cells, if the goal is full coverage."""
    caution: float = bounded(2.6, least=0, tunable=(0.5, 6.0))
    """Factor on ``isolation`` if there may be obstacles: plans fail more often, and pockets left behind cost more."""
    pull: float = bounded(0.02, least=0, tunable=(0.002, 0.2, "log"))
    """Cost of a step to the next gain, in cells."""
    stretch: float = bounded(0.0, least=0)
    """Cost of a step to the unseen cell that takes longest, in cells."""
    spare: float = bounded(0.0095, least=0, tunable=(0.0, 0.03))
    """Share of the cells that is deferred to the end, so that all others are seen sooner."""
    prior: PriorSource = one_of("source", get_args(PriorSource))
    """Source of the probability of obstacles; "none" assumes that all unknown cells are free."""
    chains: int = bounded(64, least=1)
    """Number of rooms that are sampled in parallel with ``prior`` "source"."""
    sweeps: int = bounded(3, least=1)
    """Gibbs sweeps over each sampled room at each step with new knowledge."""
    rollouts: int = bounded(0, least=0)
    """Number of sampled rooms in which tours with other first steps are compared before one is chosen, with ``prior``
    "source" and one UAV; with 24 a decision takes about four times as long; 0 disables rollouts."""
    deference: float = bounded(0.1, least=0, tunable=(0.0, 1.0))
    """Factor on the weight of a cell for each teammate that is closer to it."""
    room: int = bounded(600, least=0)
    """Largest number of cells of a map that is planned cell by cell."""
    beyond: FrontierJoint = field(default_factory=FrontierJoint)
    """Planner for larger maps, and for steps without a tour."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.beyond, FrontierJoint):
            raise InputError(f"Horizon: expected beyond to be a FrontierJoint, got {shown(self.beyond)}")

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        beyond = self.beyond.pilot(briefing)
        if briefing.shape[0] * briefing.shape[1] > self.room or briefing.level_count > 1:
            return beyond
        return HorizonPilot(briefing, self, beyond)

    def tours(self, briefing: Briefing) -> TourPlanner:
        """Return the tour planner of one UAV."""
        goal = briefing.scenario.goal
        prior = self._prior(briefing)
        caution = 1.0 if isinstance(prior, OpenPrior) else self.caution
        isolation = caution * self.isolation * 0.5 ** ((1.0 - goal) / GOAL_SCALE)
        config = BeamConfig(isolation, self.pull, self.stretch, self.width, self.depth)
        selection = None
        if isinstance(prior, RoomPrior) and self.rollouts > 0:
            selection = RolloutSelection(prior, briefing.shape, briefing.lidar_range, goal, self.rollouts)
        return TourPlanner(briefing.shape, briefing.lidar_range, prior, config, goal, self.spare, selection)

    def _prior(self, briefing: Briefing) -> Prior:
        source = briefing.generator
        if self.prior == "none":
            return OpenPrior()
        if self.prior == "source" and isinstance(source, ThesisMaps) and RoomPrior.suits(source):
            known_empty = source.obstacles == 0
            return OpenPrior() if known_empty else RoomPrior(source, briefing.rng, self.chains, self.sweeps)
        return LearnedPrior()


class HorizonPilot(Pilot):
    """Fly tours; without a tour, or if it gains nothing, hand over to another pilot."""

    def __init__(self, briefing: Briefing, policy: Horizon, beyond: Pilot) -> None:
        self.briefing = briefing
        self._deference = policy.deference
        self._tours = policy.tours(briefing)
        self._beyond = beyond
        self._paths = Paths(briefing.shape)
        self._deadlock = DeadlockResolver(self._paths, briefing.rng)
        self._known, self._deadline = -1, 0
        self._handed_over = self._step = 0
        self._flies_tour = False

    def act(self, view: View) -> int:
        """Follow the tour, and plan again whenever the map has grown or the tour has ended.

        If a teammate stays in the way, the other pilot, which can make way, takes over until the map grows.
        """
        self._beyond.explaining = self.explaining
        cell = view.cell[0] * self._paths.width + view.cell[1]
        following = self._next(view, cell)
        if self._deadlock.should_make_way(view):
            self._deadline = view.step - 1
            following = None
        self._flies_tour, self._step = following is not None, view.step
        if following is None:
            self._handed_over += 1
            self._deadlock.expect(view.cell, Action.STAY)
            return self._beyond.act(view)
        action = action_between(view.cell, divmod(following, self._paths.width))
        self._deadlock.expect(view.cell, action)
        return action

    def explain(self) -> Explanation | None:
        """Return the tour, or what the other pilot explains."""
        if not self._flies_tour:
            return self._beyond.explain()
        tour = tuple(divmod(cell, self._paths.width) for cell in self._tours.tour)
        return Explanation(step=self._step, goal=tour[-1], path=tour, note="the best tour of the beam search")

    def tally(self) -> dict[str, float]:
        """Return the number of decisions that were handed over."""
        return {"decisions_without_tour": float(self._handed_over)}

    def _next(self, view: View, cell: int) -> int | None:
        """Return the tour's next flat cell; None if there is no tour, or the tour has had no gain for too long."""
        known = map_stamp(view)
        following = self._tours.following(cell)
        if known != self._known or following is None:
            self._tours.plan(view.belief, cell, self._share(view, cell))
            following = self._tours.following(cell)
        if known != self._known:
            self._known, self._deadline = known, view.step + self._tours.length + PATIENCE
        return following if view.step <= self._deadline else None

    def _share(self, view: View, cell: int) -> NDArray[np.float64] | None:
        """Return the factors on the cells' weights, (C,): lower for each teammate that can see a cell sooner."""
        mates = remembered(view, self.briefing)
        if not mates:
            return None
        self._tours.optimistic.update(view.belief)
        own = self._tours.optimistic.first_steps(cell)
        nearer = np.zeros(own.shape, np.int64)
        for mate in mates:
            theirs = self._tours.optimistic.first_steps(mate.cell[0] * self._paths.width + mate.cell[1])
            nearer += (theirs < own) | ((theirs == own) & (mate.agent < self.briefing.agent))
        return np.asarray(self._deference**nearer)
