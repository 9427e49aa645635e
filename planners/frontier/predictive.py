"""Frontier clusters in an order of low mean waiting time, weighted by the expected unknown area behind them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from indoor_explorers.env.grid.arrays import Distances
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.frontier.latency import FrontierLatency, LatencyPilot
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters
from indoor_explorers.planners.toolbox.pockets.estimates import PocketEstimates
from indoor_explorers.planners.toolbox.pockets.outlook import (
    ClusterJudge,
    LevelEstimateUser,
    Outlook,
    OutlookParameters,
)


@renamed()
@dataclass(frozen=True, kw_only=True)
class FrontierPredictive(LevelEstimateUser, OutlookParameters, FrontierLatency):
    """Fly as ``frontier-latency`` does, but weigh clusters by the probability of unknown free cells, and defer some.

    A network estimates from the map around each cluster how much unknown free space is behind it
    (:mod:`indoor_explorers.planners.toolbox.pockets`). Clusters with few expected cells for the length of the path are
    deferred as far as the goal allows (:mod:`indoor_explorers.planners.toolbox.pockets.outlook`). A UAV declares to be
    done when it expects to know the share ``aim`` of all free cells.

    The order: A. Blum et al., "The minimum latency problem", STOC 1994, doi:10.1145/195058.195125. The estimates and
    what they defer are this project's.
    """

    worth: float = 0.8
    """Exponent of gains as weights of waiting times; 0 weights all clusters equally."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return PredictivePilot(briefing, self)


class PredictivePilot(LatencyPilot):
    """Weigh and defer clusters by the network's estimates."""

    def __init__(self, briefing: Briefing, policy: FrontierPredictive) -> None:
        super().__init__(briefing, policy)
        self._estimator = policy.estimate_files.estimator(briefing)
        self._judge = ClusterJudge(briefing, policy)
        self._aim = policy.aim
        self._expected = 0.0
        """Share of all free cells that this UAV expects to know."""

    def estimates(self, view: View, clusters: Clusters) -> PocketEstimates:
        """Return the network's estimates for K clusters."""
        assert self._estimator is not None
        return self._estimator.estimate(view.belief, clusters)

    def outlook(self, view: View, clusters: Clusters, away: Distances) -> Outlook:
        """Return the outlook of K clusters, ``away`` (K,) steps from the UAV.

        On maps of several levels it is the same for all unless there are ``level_weights``.
        """
        if self._estimator is None:
            return super().outlook(view, clusters, away)
        known = int(np.count_nonzero(view.belief == FREE))
        estimates = self.estimates(view, clusters)
        self._expected = known / (known + float(estimates.sizes.sum()))
        return self._judge.outlook(estimates, known, away)

    def choose_goal(self, view: View) -> None:
        """Choose a goal, and declare to be done when enough of the map is known."""
        super().choose_goal(view)
        self.done = self.done or self._expected >= self._aim
