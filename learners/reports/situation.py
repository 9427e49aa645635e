"""The observation of a choice between exploring on and flying home: a row of numbers from one UAV's own knowledge.

Lengths are in lidar ranges and times in shares of the budget or of the flight home, so that one network fits every
lidar, map and deadline.
"""

from __future__ import annotations

from math import log, log1p
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.policies.view import View
from indoor_explorers.planners.toolbox.explorers import added
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters
from indoor_explorers.planners.toolbox.pockets.estimates import DEFAULT_FILES, EstimateFiles
from indoor_explorers.planners.toolbox.reporting import ADDED, ReportingPilot, home_of

#: Numbers of a situation.
NUMBERS = 25
#: Unknown free cells that are expected besides those behind clusters, as a share of the known ones.
BESIDE = 0.01
#: Ratio of waiting to cost at which the rule that the training begins with is undecided: see :attr:`Situation.rule`.
UNDECIDED = 0.5
#: Largest value of the rule, either way.
CLEAR = 3.0
#: Points that an unknown base costs over the whole budget.
POINTS = 100.0
#: Points that it costs if the base knows under 99 % at the deadline, and the most in a training: see :mod:`.flights`.
LATE_COST, HIGHEST_LATE_COST = 15.0, 300.0
#: Lidar ranges of flight over which the recent rate of discovery is taken.
RECENT = 5


class Situation(NamedTuple):
    """What is known at a choice."""

    numbers: NDArray[np.float32]
    """(NUMBERS,) inputs of the network."""
    rule: float
    """The value of flying home to the rule of :class:`~indoor_explorers.planners.return_to_base.ReturnToBase`: the
    logarithm of the time that unreported cells have waited, in relation to that by which the flight delays others."""


class SituationObserver:
    """Observe the choices of one pilot, with the free cells that are expected behind frontier clusters.

    Args:
        pilot: The pilot that chooses.
        late_cost: Points that it costs if the base knows under 99 % at the deadline.
        files: Files of the estimates' weights.

    """

    def __init__(
        self, pilot: ReportingPilot, late_cost: float = LATE_COST, files: EstimateFiles = DEFAULT_FILES
    ) -> None:
        self._pilot, self._late_cost = pilot, late_cost
        self._range = float(pilot.briefing.lidar_range)
        self._estimator = files.estimator(pilot.briefing)
        self._known: list[int] = []

    def note(self) -> None:
        """Note how much is known at this step."""
        self._known.append(self._pilot.known)

    def observe(self, view: View) -> Situation:
        """Return the situation of the pilot."""
        pilot, reach, team = self._pilot, self._range, self._pilot.briefing.team
        known, home = pilot.known, pilot.home
        free, left, flight = max(1, int(np.count_nonzero(view.belief == FREE))), view.budget - view.step, 2 * home
        clusters = frontier_clusters(view.belief, reach, pilot.briefing.rise)
        expected = 0.0
        if self._estimator is not None and clusters.size:
            expected = float(self._estimator.estimate(view.belief, clusters).sizes.sum())
        waited = pilot.waited * free / known
        cost = (expected + BESIDE * free) * flight / team
        ratio = log(max(waited, 1e-3) / max(cost, 1e-3))
        silent = view.step if view.base_age is None else view.base_age
        away = pilot.navigator.paths.field(view.belief, view.cell).ravel()[clusters.cells]
        from_home = pilot.steps_home.ravel()[clusters.cells]
        from_home = from_home[from_home < UNREACHABLE]
        numbers = (
            view.step / view.budget,
            min(home / left, 2.0),
            min(home / reach, 10.0) / 5.0,
            log1p(left / reach) / 5.0,
            1.0 - pilot.reported / known,
            silent / view.budget,
            min(silent / (flight + reach), 10.0) / 5.0,
            log1p(pilot.waited / known / reach) / 3.0,
            max(-5.0, min(5.0, ratio)) / 5.0,
            expected / (free + expected),
            min((expected * view.step / free + home) / left, 3.0),
            self._recently(view, known),
            *self._of_teammates(view),
            min(clusters.size / 30.0, 2.0),
            min(int(away.min()) / reach, 10.0) / 5.0 if away.size else 0.0,
            min(int(from_home.min()) / reach, 10.0) / 5.0 if from_home.size else 0.0,
            min(int(from_home.max(initial=0)) / reach, 20.0) / 10.0,
            reach / 10.0,
            left * team * reach / free / 10.0,
            self._late_cost / (POINTS + self._late_cost),
        )
        return Situation(np.array(numbers, np.float32), max(-CLEAR, min(CLEAR, ratio - log(UNDECIDED))))

    def _recently(self, view: View, known: int) -> float:
        """Return the recent rate of discovery in relation to that of the whole flight."""
        steps = int(RECENT * self._range)
        if len(self._known) <= steps:
            return 1.0
        return min((known - self._known[-steps]) / steps * view.step / known, 3.0)

    def _of_teammates(self, view: View) -> tuple[float, ...]:
        pilot, reach = self._pilot, self._range
        linked = [mate for mate in view.mates if mate.age == 0]
        nearer = sum(home_of(mate) < (pilot.home, pilot.briefing.agent) for mate in linked)
        recent = [added(mate, ADDED) for mate in view.mates if mate.age < RECENT * reach]
        return (
            pilot.briefing.team / 4.0,
            len(linked) / 4.0,
            min((mate.age for mate in view.mates), default=view.budget) / view.budget,
            nearer / 4.0,
            float(any(len(numbers) == ADDED and numbers[1] > 0.0 for numbers in recent)),
            min([home_of(mate)[0] for mate in linked] + [10.0 * reach]) / reach / 5.0,
        )
