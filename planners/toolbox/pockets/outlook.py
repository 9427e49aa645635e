"""Outlook: which frontier clusters probably lead to unknown free cells, and which can wait, from estimated pockets.

A UAV that aims at 99 % may leave 1 % unknown. Clusters with the most steps per expected cell are deferred, as long as
the expected cells of all deferred ones are no more than the allowance: 1 % of the cells found so far. An allowance of
1 % of the whole map would be used up early, and be missing later.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Distances, Mask
from indoor_explorers.env.policies.view import Briefing
from indoor_explorers.env.provenance import joined, record_of, recorded_maps
from indoor_explorers.planners.toolbox.parameters import Parameters, bounded
from indoor_explorers.planners.toolbox.pockets.estimates import EstimateFiles, PocketEstimates
from indoor_explorers.planners.toolbox.pockets.network import THRESHOLDS


@dataclass(frozen=True, kw_only=True)
class EstimateUser(Parameters):
    """The weights of the estimates and their provenance, for the policies that use them.

    Raises:
        InputError: a file of weights is missing or not one of this network.

    """

    pocket_weights: str | None = None
    """Path of a training's folder, or of weights, of the network that estimates pockets; None: the shipped ones."""

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self.estimate_files

    @property
    def estimate_files(self) -> EstimateFiles:
        """The files of the weights of the estimates."""
        return EstimateFiles.named(self.pocket_weights)

    def provenance(self) -> dict[str, str]:
        """Return a hash of each file of the estimates' weights."""
        named = zip(("pocket_weights", "level_weights"), self.estimate_files, strict=True)
        return {name: hashlib.sha256(path.read_bytes()).hexdigest()[:16] for name, path in named if path}

    def seen_maps(self) -> dict[str, list[str]]:
        """Return the maps that the estimates were learned from."""
        return joined([recorded_maps(record_of(path)) for path in self.estimate_files if path])


@dataclass(frozen=True, kw_only=True)
class LevelEstimateUser(EstimateUser):
    """The same with estimates on maps of several levels, which are off by default."""

    level_weights: str | None = None
    """The same for maps of several levels, or ``shipped`` for the shipped ones; None: there are no estimates there."""

    @property
    def estimate_files(self) -> EstimateFiles:
        """The files of the weights of the estimates."""
        return EstimateFiles.named(self.pocket_weights, self.level_weights)


@dataclass(frozen=True, kw_only=True)
class OutlookParameters(Parameters):
    """Parameters of the outlook."""

    skip: float = bounded(0.75, least=0, tunable=(0.0, 1.0))
    """Most expected cells of all deferred clusters, as a share of the cells that may stay unknown."""
    risk: float = bounded(0.1, least=0, tunable=(0.01, 0.5, "log"))
    """Largest probability that a deferred cluster hides over a quarter of the cells that may stay unknown."""
    visit: float = bounded(3.0, least=0, tunable=(0.3, 10.0, "log"))
    """Steps that a visit costs besides the path to the cluster, in lidar ranges."""
    near: int = bounded(2, least=0)
    """Steps within which a cluster is never deferred."""
    aim: float = bounded(0.99, least=0)
    """Coverage to reach as soon as possible; the scenario's goal if that is lower."""


class Outlook(NamedTuple):
    """Expectation for K clusters."""

    deferred: Mask
    """(K,) bool, whether the cluster can wait until no others are left."""
    chances: NDArray[np.float64]
    """(K,) probability that any unknown free cell is behind it."""


class ClusterJudge:
    """Compute the outlook of one UAV's clusters from the estimates."""

    def __init__(self, briefing: Briefing, parameters: OutlookParameters) -> None:
        self._parameters = parameters
        self._visit = parameters.visit * briefing.lidar_range
        self._share = parameters.skip * (1.0 - min(parameters.aim, briefing.scenario.goal))

    def outlook(self, estimates: PocketEstimates, known: int, away: Distances) -> Outlook:
        """Return the outlook of K clusters.

        ``known`` is the number of known free cells, and ``away`` (K,) are the steps from the UAV.
        """
        allowance = self._share * known
        large = int(np.searchsorted(THRESHOLDS, allowance / 4.0, side="right")) - 1
        safe = np.flatnonzero(estimates.tails[:, large] <= self._parameters.risk)
        order = safe[np.argsort(estimates.sizes[safe] / (self._visit + away[safe]), kind="stable")]
        deferred = np.zeros(len(away), np.bool_)
        deferred[order[np.cumsum(estimates.sizes[order]) <= allowance]] = True
        return Outlook(deferred & (away > self._parameters.near), estimates.tails[:, 0])
