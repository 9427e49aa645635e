"""The observation of a choice among places: one place, a row of numbers, for each frontier cluster.

Distances are in lidar ranges, so that one network fits every lidar. Nothing comes from the true map.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.policies.view import Mate, View
from indoor_explorers.learners.places.options import OPTION_COMMON, Options
from indoor_explorers.learners.places.task_inputs import TASK_COMMON, TASK_PLACE, TaskInputs
from indoor_explorers.planners.toolbox.coordination.out_of_contact import OutOfContact
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters
from indoor_explorers.planners.toolbox.information.cluster_places import (
    LEFT_TO_OTHERS,
    ClusterPlaces,
    PlaceParameters,
    halved_by_mates,
    log_gains,
    waiting_weights,
)
from indoor_explorers.planners.toolbox.information.lookouts import Lookouts
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.teammates import remembered
from indoor_explorers.planners.toolbox.pockets.estimates import DEFAULT_FILES, EstimateFiles, PocketEstimates
from indoor_explorers.planners.toolbox.pockets.network import THRESHOLDS
from indoor_explorers.planners.toolbox.pockets.outlook import ClusterJudge, Outlook, OutlookParameters
from indoor_explorers.planners.toolbox.routing.min_latency import best_orders

#: Most places of a scene.
MOST = 12
#: Numbers about each place, and about the whole scene.
PLACE, COMMON = 34, 10
#: The columns of a place with the estimates of the free space behind it, and with the other places.
GUESS, OTHERS = slice(7, 18), slice(18, 31)
#: Largest cost of a place beyond that of the best one, in lidar ranges.
COSTLIEST = 20.0
#: The parameters of ``frontier-predictive`` that the shipped network was trained with. They stay as they are when the
#: planner is tuned, since the network's inputs depend on them; a test reports where the two differ.
TRAINED_ON = PlaceParameters(
    decay_length=0.5, isolation=8.0, discount_rate=2.4, latency=16.0, worth=0.8, switch_cost=0.2, clusters=MOST
)
#: Likewise, the parameters by which clusters are deferred,
TRAINED_OUTLOOK = OutlookParameters(skip=0.75, risk=0.1, visit=3.0, near=2, aim=0.99)
#: and the spacing of a cluster's cells, and the distance within which a cell is the last goal, in lidar ranges.
TRAINED_STRIDE, TRAINED_SAME = 0.3, 0.2
#: Weights of the mean waiting time in the orders that are compared, of views and of expected cells; a third has none.
LATENCY_OF_VIEWS, LATENCY_OF_SIZES = TRAINED_ON.latency, 3.0
#: Thresholds whose probabilities a place shows, by their numbers.
TAILS = np.searchsorted(THRESHOLDS, [0, 3, 12, 48, 192])
_DEFERRED_LATER, _TAKEN_LATER = 100.0, 1000.0

Numbers = NDArray[np.float64]


class Scene(NamedTuple):
    """K places to choose from, and perhaps O options."""

    cells: NDArray[np.int32]
    """(K,) flat cells."""
    places: NDArray[np.float32]
    """(K, PLACE) numbers about each place; with the task's inputs ``TASK_PLACE`` more."""
    common: NDArray[np.float32]
    """(COMMON,) numbers about all of them; with the task's inputs ``TASK_COMMON`` more, with options their numbers."""
    costs: NDArray[np.float32]
    """(K,) cost of the best order that begins there above the cheapest order, to ``frontier-predictive``."""
    owner: NDArray[np.int64]
    """(K,) numbers of their clusters."""
    steps: Numbers
    """(K,) distances from the UAV in lidar ranges."""
    between: Numbers
    """(K, K) distances between the places in lidar ranges."""
    rules: NDArray[np.float32] = np.empty(0, np.float32)
    """(O,) values of the options to rules; -inf where there is none."""

    def with_options(self, options: Options) -> Scene:
        """Return the scene with options."""
        return self._replace(common=np.concatenate([self.common, options.numbers]), rules=options.rules)


def input_sizes(task: bool, options: bool = False) -> tuple[int, int]:
    """Return how many numbers a network sees about a place and about all of them.

    ``task`` and ``options`` tell whether it has the task's inputs, and those of the options.
    """
    return PLACE + TASK_PLACE * task, COMMON + TASK_COMMON * task + OPTION_COMMON * options


class _Candidates(NamedTuple):
    """Quantities of each of K places by itself."""

    cells: NDArray[np.int32]
    owner: NDArray[np.int64]
    steps: Numbers
    """(K,) in lidar ranges."""
    views: Numbers
    """(K,) weighted view gains."""
    factors: Numbers
    """(K,) for teammates that are closer."""
    kept: Mask
    """(K,) whether it is at the last goal."""

    def at(self, chosen: NDArray[np.int64] | Mask) -> _Candidates:
        return _Candidates._make(each[chosen] for each in self)


class _Clusters(NamedTuple):
    """All clusters with their estimates."""

    clusters: Clusters
    estimates: PocketEstimates
    outlook: Outlook
    known: int
    """Known free cells."""
    expected: float
    """Unknown free cells behind all clusters in reach."""


class Observer:
    """Observe the choice of one UAV.

    Args:
        pilot: The pilot that flies to the places.
        guess: Whether to use the estimates of the free space behind the clusters.
        lookouts: Most places near the UAV that need not be at a frontier.
        task: Whether to observe what is harder about the task, see :class:`TaskInputs`.
        sector: Preference for the own sector while teammates were never heard; see :class:`OutOfContact`.
        files: Files of the estimates' weights.

    """

    def __init__(
        self,
        pilot: GoalPilot,
        *,
        guess: bool = True,
        lookouts: int = 0,
        task: bool = False,
        sector: float = 0.0,
        files: EstimateFiles = DEFAULT_FILES,
    ) -> None:
        self._pilot, self._briefing = pilot, pilot.briefing
        self._range = float(pilot.briefing.lidar_range)
        self._found = ClusterPlaces(pilot, TRAINED_ON, stride=TRAINED_STRIDE, same=TRAINED_SAME)
        self.lookouts = Lookouts(pilot, self._found, TRAINED_ON.discount_rate, lookouts)
        self._estimator = files.estimator(pilot.briefing) if guess else None
        self._judge = ClusterJudge(pilot.briefing, TRAINED_OUTLOOK)
        self._task = TaskInputs(pilot) if task else None
        self._out_of_contact = OutOfContact(pilot.briefing, sector=sector) if sector else None

    def observe(self, view: View) -> Scene | None:
        """Return the places that a UAV can choose from; None if it can reach none."""
        found = self._found.found(view)
        if not len(found.cells):
            return None
        found = self.lookouts.added_to(view, found)
        about = self._expected(view, found.clusters, found.away)
        mates = remembered(view, self._briefing)
        fields = [self._pilot.steps_from(view, mate.cell).ravel() for mate in mates]
        others = [each[found.cells] for each in fields]
        factors = halved_by_mates(found.steps, others, [mate.agent < self._briefing.agent for mate in mates])
        if self._out_of_contact is not None:
            factors *= self._out_of_contact.left_by_unheard_at_cells(view, found.cells)
        views, kept = self._found.views(view, found.cells), self._found.at_goal(found.cells)
        every = _Candidates(found.cells, found.owner, found.steps / self._range, views, factors, kept)
        return self._scene(view, self._best(view, every, about.outlook), about, mates, fields)

    def _expected(self, view: View, clusters: Clusters, away: NDArray[np.int32]) -> _Clusters:
        known = int(np.count_nonzero(view.belief == FREE))
        if self._estimator is None:
            nothing = PocketEstimates(np.zeros((clusters.size, len(THRESHOLDS))), *np.zeros((2, clusters.size)))
            outlook = Outlook(np.zeros(clusters.size, np.bool_), np.ones(clusters.size))
            return _Clusters(clusters, nothing, outlook, known, 0.0)
        estimates = self._estimator.estimate(view.belief, clusters)
        outlook = self._judge.outlook(estimates, known, away)
        return _Clusters(clusters, estimates, outlook, known, float(estimates.sizes[away < UNREACHABLE].sum()))

    def _best(self, view: View, found: _Candidates, outlook: Outlook) -> _Candidates:
        """Return one place for each cluster, the most promising ones first."""
        gains = found.factors * outlook.chances[found.owner] * found.views
        scores = log_gains(gains) - TRAINED_ON.discount_rate * found.steps
        best = self._found.best_of_each(found.owner, scores, found.kept)
        taken = found.factors[best] <= LEFT_TO_OTHERS * found.factors.max()
        rank = scores[best] - _DEFERRED_LATER * outlook.deferred[found.owner[best]] - _TAKEN_LATER * taken
        best = best[np.argsort(-rank, kind="stable")[:MOST]]
        return found.at(best[self.lookouts.distinct(view, found.cells[best])])

    def _scene(
        self, view: View, found: _Candidates, about: _Clusters, mates: list[Mate], fields: list[NDArray[np.int32]]
    ) -> Scene:
        count = len(found.cells)
        between = np.zeros((1, 1))
        if count > 1:
            between = self._pilot.paths.matrix(view.belief, found.cells) / self._range
        gains = found.factors * about.outlook.chances[found.owner] * found.views
        orders, costs, least = _orders(found, between, gains, about)
        columns = [
            *self._own(found, about.clusters),
            *self._behind(found, gains, about),
            *orders,
            *_neighbours(found.steps, between),
            *self._of_teammates(found, fields),
        ]
        common = self._common(about, count, len(mates), least)
        if self._task is not None:
            columns += self._task.of_places(view, found.cells, found.steps, mates)
            common += self._task.common(view, mates)
        costs = np.minimum(costs - costs.min(), COSTLIEST).astype(np.float32)
        places = np.column_stack(columns).astype(np.float32)
        return Scene(found.cells, places, np.array(common, np.float32), costs, found.owner, found.steps, between)

    def _own(self, found: _Candidates, clusters: Clusters) -> list[Numbers | Mask]:
        widths = (clusters.ends[1:] - clusters.ends[:-1])[found.owner] / self._range
        views = np.log1p(found.views)
        near = found.steps <= found.steps.min()
        distance = [np.minimum(found.steps, 10.0) / 5.0, np.log1p(found.steps)]
        return [*distance, views / 5.0, (views - views.max()) / 5.0, np.minimum(widths, 3.0), found.kept, near]

    def _behind(self, found: _Candidates, gains: Numbers, about: _Clusters) -> list[Numbers | Mask]:
        estimates, owner = about.estimates, found.owner
        sizes, visit = estimates.sizes[owner], (found.steps + 3.0) * self._range
        allowance = max(0.01 * about.known, 1.0)
        return [
            np.log1p(gains) / 5.0,
            *estimates.tails[owner][:, TAILS].T,
            np.log1p(sizes) / 5.0,
            np.minimum(np.log1p(sizes / allowance), 5.0) / 2.0,
            np.minimum(sizes / visit, 10.0) / 5.0,
            np.log1p(estimates.depths[owner]) / 4.0,
            about.outlook.deferred[owner],
        ]

    def _of_teammates(self, found: _Candidates, fields: list[NDArray[np.int32]]) -> list[Numbers]:
        own = np.minimum(found.steps, 10.0) / 5.0
        theirs = np.full(len(own), 2.0)
        if fields:
            theirs = np.minimum(np.min([each[found.cells] for each in fields], axis=0) / self._range, 10.0) / 5.0
        return [found.factors, theirs, theirs - own]

    def _common(self, about: _Clusters, count: int, mates: int, least: float) -> list[float]:
        waiting = float(about.estimates.sizes[about.outlook.deferred].sum())
        return [
            np.log1p(about.known) / 8.0,
            np.log1p(about.expected) / 8.0,
            about.known / (about.known + about.expected),
            count / MOST,
            min(about.clusters.size / 30.0, 3.0),
            np.log1p(waiting / max(0.01 * about.known, 1.0)),
            self._briefing.team / 4.0,
            mates / 4.0,
            self._range / 10.0,
            min(least / 40.0, 3.0),
        ]


def _orders(
    found: _Candidates, between: Numbers, gains: Numbers, about: _Clusters
) -> tuple[list[Numbers], Numbers, float]:
    """Return costs and positions of the K places in several orders, the planner's costs (K,), and their least."""
    every = np.ones(len(found.cells), np.bool_)
    wanted = ~about.outlook.deferred[found.owner]
    wanted = wanted if wanted.any() else every
    worth, sizes = waiting_weights(gains, TRAINED_ON.worth), np.maximum(about.estimates.sizes[found.owner], 1e-3)
    asked = (
        (worth, LATENCY_OF_VIEWS, wanted),
        (sizes, LATENCY_OF_SIZES, wanted),
        (np.ones(len(every)), 0.0, wanted),
        (np.ones(len(every)), 0.0, every),
    )
    columns: list[Numbers] = []
    costs, least = np.zeros(len(every)), 0.0
    for weights, latency, among in asked:
        some = np.flatnonzero(among)
        found_costs, positions = np.zeros(1), np.zeros(1)
        if len(some) > 1:
            share = weights[some] / weights[some].sum()
            nearer = np.ascontiguousarray(between[np.ix_(some, some)])
            found_costs, positions = best_orders(found.steps[some], nearer, share, latency)
        beyond = np.full(len(every), 1.0 + np.ptp(found_costs))
        beyond[some] = found_costs - found_costs.min()
        place = np.ones(len(every))
        place[some] = positions / max(1, len(some) - 1)
        columns += [np.minimum(beyond / (1.0 + 0.25 * latency), 5.0), place]
        if weights is worth:
            costs, least = beyond - TRAINED_ON.switch_cost * found.kept, float(found_costs.min())
            costs[~among] = np.inf
    return columns, costs, least


def _neighbours(steps: Numbers, between: Numbers) -> list[Numbers]:
    """Return distances to, and numbers of, the other places around each of K places."""
    count = len(steps)
    apart = between + np.diag(np.full(count, np.inf))
    nearest = np.minimum(apart.min(axis=1), 10.0) / 3.0 if count > 1 else np.full(1, 3.0)
    return [
        np.minimum(between, 6.0).sum(axis=1) / max(1, count - 1) / 3.0,
        nearest,
        (apart < 1.0).sum(axis=1) / 8.0,
        (apart < 3.0).sum(axis=1) / 8.0,
        (steps[None] > between).sum(axis=1) / 16.0,
    ]
