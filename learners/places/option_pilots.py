"""Pilots of the options beside places: they fly as the network of places, and report, relay or close loops by it."""

from __future__ import annotations

from indoor_explorers.env.grid.cells import UNREACHABLE, Action
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import View
from indoor_explorers.learners.places.options import Option, Options
from indoor_explorers.learners.places.pilot import PlacesPilot
from indoor_explorers.learners.reports.situation import LATE_COST, NUMBERS, SituationObserver
from indoor_explorers.planners.toolbox.localisation.loops import LoopPilot
from indoor_explorers.planners.toolbox.pockets.estimates import DEFAULT_FILES, EstimateFiles
from indoor_explorers.planners.toolbox.reporting import ReportingPilot

#: Values of a relay and of a loop closure to the rules that a training begins with: never, and always.
NO_RELAY, CLOSES = -2.0, 2.0


def with_options(
    pilot: PlacesPilot, policy: Policy, files: EstimateFiles = DEFAULT_FILES, late_cost: float = LATE_COST
) -> Pilot:
    """Return a pilot of one UAV that flies as another one, and takes the options that its network prefers.

    Args:
        pilot: The pilot that chooses among places, and options if its network values any.
        policy: Its policy.
        files: Files of the estimates' weights.
        late_cost: Points that it costs if a base knows under 99 % at the deadline.

    """
    whole: Pilot = pilot
    if not pilot.values_options:
        return whole
    if pilot.briefing.base is not None:
        whole = PlacesReportingPilot(pilot, policy, files, late_cost)
    if pilot.briefing.scenario.drift.rate > 0.0:
        whole = PlacesLoopPilot(pilot, policy, whole)
    return whole


class PlacesReportingPilot(ReportingPilot):
    """Report and relay when the network of places prefers it to all places.

    The rules of :class:`ReportingPilot` stay: who of UAVs in contact flies home, and when it is time at the latest.
    """

    def __init__(self, pilot: PlacesPilot, policy: Policy, files: EstimateFiles, late_cost: float) -> None:
        super().__init__(pilot.briefing, policy, pilot)
        self._places, self._observer = pilot, SituationObserver(self, late_cost, files)
        self._relays_until = 0
        pilot.choose_among(self._options)

    def act(self, view: View) -> int:
        """Explore, report or relay."""
        self._view = view
        action = super().act(view)
        self._observer.note()
        return action

    def is_worth_it(self, view: View) -> bool:
        """Return False: the network tells it when it chooses a place."""
        return False

    def _options(self, options: Options) -> None:
        view = self._view
        situation = self._observer.observe(view)
        options.numbers[:NUMBERS] = situation.numbers
        if view.base_age == 0:
            if self.briefing.team > 1:
                options.rules[Option.RELAY] = NO_RELAY
        elif self.home < UNREACHABLE and self.known > self.reported:
            options.rules[Option.REPORT] = situation.rule

    def _explore(self, view: View) -> int:
        if view.step < self._relays_until and view.base_age == 0:
            return int(Action.STAY)
        action = super()._explore(view)
        taken = self._places.take_option(Option.REPORT, Option.RELAY)
        if taken is Option.RELAY:
            self._places.message = None  # it flies to no goal
            self._relays_until = view.step + int(self._places.replan_period)
            return int(Action.STAY)
        if taken is Option.REPORT:
            self._send_home(view)
            if self._returning:
                return self._fly_home(view)
        return action


class PlacesLoopPilot(LoopPilot):
    """Close loops when the network of places prefers it to all places.

    Whether the pose is wrong, and how the map is mended at the end, is told by the rules of :class:`LoopPilot`.
    """

    def __init__(self, pilot: PlacesPilot, policy: Policy, whole: Pilot) -> None:
        super().__init__(pilot.briefing, policy, whole)
        self._places, self._closes_until, self._may_close_at = pilot, 0, -1
        pilot.choose_among(self._options)

    def act(self, view: View) -> int:
        """Explore, close a loop, or look again at what is wrong."""
        self._view = view
        return super().act(view)

    def is_worth_it(self, view: View) -> bool:
        """Tell whether the network has preferred to close a loop, or nothing is left to explore before."""
        self._may_close_at = view.step
        if not self._was_off:
            self._places.choose_soon()
        return view.step < self._closes_until or self._is_explored(self._estimated(view))

    def _options(self, options: Options) -> None:
        if self._may_close_at != self._view.step:
            return
        closure = self.cheapest_closure(self._view, self._belief(self._view))
        if closure is not None:
            reach, error = self._briefing.lidar_range, max(map(abs, self.trajectory.error))
            lengths = (min(each / reach, 10.0) / 5.0 for each in (closure.steps, closure.missed))
            options.numbers[NUMBERS:] = (1.0, *lengths, min(closure.saved, 2.0), min(error, 4) / 2.0)
            options.rules[Option.CLOSE] = CLOSES

    def _explore(self, view: View) -> int:
        action = super()._explore(view)
        if self._places.take_option(Option.CLOSE) is Option.CLOSE:
            self._closes_until = view.step + int(self._places.replan_period)
            closing = self._close_loop(self._view)
            if closing is not None:
                return closing
        return action
