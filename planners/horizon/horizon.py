"""Receding horizon: plan the whole tour that is left, fly its first step, plan again when the map has grown."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.maps.generators.thesis import ThesisMaps
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.coordination.teammates import remembered
from indoor_explorers.planners.frontier.joint import FrontierJoint
from indoor_explorers.planners.horizon.beam import BeamConfig
from indoor_explorers.planners.horizon.learned_prior import LearnedPrior, OpenPrior, Prior
from indoor_explorers.planners.horizon.rollout_choice import RolloutSelection
from indoor_explorers.planners.horizon.room_prior import RoomPrior
from indoor_explorers.planners.horizon.tour_planner import TourPlanner
from indoor_explorers.planners.navigation.deadlock import DeadlockResolver
from indoor_explorers.planners.navigation.navigator import action_between
from indoor_explorers.planners.navigation.paths import Paths, count_known
from indoor_explorers.planners.parameters import at_least

#: Isolation matters less when the goal leaves cells out: it halves with each such share of the coverage.
GOAL_SCALE = 0.05
#: A tour is given up until the map grows when it has shown nothing for its length plus this many steps.
PATIENCE = 8


@dataclass(frozen=True, kw_only=True)
class Horizon(Policy):
    """Plan a tour of all unseen cells by beam search and keep it while it stands; on large maps, fly to frontiers.

    In rooms of up to ``room`` cells the search is over (cell, unseen set), taking unknown cells to be free to fly
    through and transparent. It aims at the scenario's goal coverage. Cells count by their chance to be free:
    with ``prior`` "source" and a generator of random rooms, the chance is worked out from the generator's
    statistics (``briefing.generator``: number, sizes and margins of obstacles; never the map); otherwise, and with
    "belief", it is learned during the flight from the UAV's own map. Beyond ``room`` cells, or where
    no tour is found, ``beyond`` looks a few frontiers ahead instead.

    Receding-horizon exploration: A. Bircher et al., ICRA 2016, doi:10.1109/ICRA.2016.7487281; the search over whole
    tours is this project's.
    """

    uses_generator: ClassVar[bool] = True

    width: int = 100
    """States that the beam keeps at each step."""
    depth: int = 80
    """Steps that the beam looks ahead."""
    isolation: float = 8.0
    """Extra weight of an unseen cell with nothing unseen around it, in cells, when everything is to be seen."""
    caution: float = 2.6
    """Factor of ``isolation`` where there may be obstacles: they upset plans, and pockets left behind cost more."""
    pull: float = 0.02
    """What a step to the next gain costs, in cells."""
    stretch: float = 0.0
    """What a step to the unseen cell that takes longest costs, in cells."""
    spare: float = 0.0095
    """Share of the cells that is left for the very last, so that nearly all are seen sooner."""
    prior: Literal["source", "belief", "none"] = "source"
    """Where the chance of obstacles comes from; "none" takes all unknown cells to be free."""
    chains: int = 64
    """Rooms that are sampled at a time for ``prior`` "source"."""
    sweeps: int = 3
    """How often each sampled room is drawn anew at each step that shows something new."""
    rollouts: int = 0
    """Sampled rooms in which tours with other first steps are tried before one is taken, with ``prior`` "source" and
    one UAV; 24 make a decision take about four times as long, 0 is none."""
    deference: float = 0.1
    """Weight of a cell for each teammate that is nearer to it."""
    room: int = 600
    """Cells of the largest map that is planned cell by cell."""
    beyond: FrontierJoint = field(default_factory=FrontierJoint)
    """What flies larger maps, and where there is no tour."""

    def __post_init__(self) -> None:
        at_least(self, 1, "width", "depth", "chains", "sweeps")
        at_least(
            self,
            0.0,
            "rollouts",
            "isolation",
            "caution",
            "pull",
            "stretch",
            "spare",
            "deference",
            "room",
        )
        if self.prior not in ("source", "belief", "none"):
            raise InputError(f"Horizon: expected prior to be source, belief or none, got {self.prior!r}")

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the mind of one UAV."""
        beyond = self.beyond.pilot(briefing)
        if briefing.shape[0] * briefing.shape[1] > self.room:
            return beyond
        return HorizonPilot(briefing, self, beyond)

    def tours(self, briefing: Briefing) -> TourPlanner:
        """Return the planner of one UAV's tours."""
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
    """Fly tours; where there is none or it leads nowhere, hand over to another pilot."""

    def __init__(self, briefing: Briefing, policy: Horizon, beyond: Pilot) -> None:
        self.briefing = briefing
        self._deference = policy.deference
        self._tours = policy.tours(briefing)
        self._beyond = beyond
        self._paths = Paths(briefing.shape)
        self._deadlock = DeadlockResolver(self._paths, briefing.rng)
        self._known, self._deadline = -1, 0
        self._handed_over = 0

    def act(self, view: View) -> int:
        """Follow the tour, planning again whenever the map has grown or the tour has ended.

        When a teammate stays in the way, the other pilot takes over until the map grows: it can make way.
        """
        cell = view.cell[0] * self._paths.width + view.cell[1]
        following = self._next(view, cell)
        if self._deadlock.should_make_way(view):
            self._deadline = view.step - 1
            following = None
        if following is None:
            self._handed_over += 1
            self._deadlock.expect(view.cell, Action.STAY)
            return self._beyond.act(view)
        action = action_between(view.cell, divmod(following, self._paths.width))
        self._deadlock.expect(view.cell, action)
        return action

    def tally(self) -> dict[str, float]:
        """Return how many decisions were handed over."""
        return {"decisions_without_tour": float(self._handed_over)}

    def _next(self, view: View, cell: int) -> int | None:
        """Return the tour's next flat cell; None when there is none, or the tour has shown nothing for too long."""
        known = count_known(view.belief)
        following = self._tours.following(cell)
        if known != self._known or following is None:
            self._tours.plan(view.belief, cell, self._share(view, cell))
            following = self._tours.following(cell)
        if known != self._known:
            self._known, self._deadline = known, view.step + self._tours.length + PATIENCE
        return following if view.step <= self._deadline else None

    def _share(self, view: View, cell: int) -> NDArray[np.float64] | None:
        """Return how much of each cell is this UAV's to see, (C,): less for each teammate that can see it sooner."""
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
