"""Frontier clusters weighted by the true sizes of pockets, with errors added: how good must an estimate be?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.frontier.predictive import FrontierPredictive, PredictivePilot
from indoor_explorers.planners.toolbox.frontiers.clusters import Clusters, middles
from indoor_explorers.planners.toolbox.parameters import bounded
from indoor_explorers.planners.toolbox.pockets.estimates import PocketEstimates
from indoor_explorers.planners.toolbox.pockets.labels import true_pockets
from indoor_explorers.planners.toolbox.pockets.network import THRESHOLDS

#: Reported size, in cells, of a mistaken cluster that hides nothing.
SUPPOSED = 30.0
#: Side of the squares of the map that share an error, in cells: a cluster keeps its error while it moves a little.
SQUARE = 6


@renamed()
@dataclass(frozen=True, kw_only=True)
class FrontierInformed(FrontierPredictive):
    """Fly as ``frontier-predictive`` does, with the true sizes of pockets, or with sizes that have a given error.

    It uses the sizes alone, and nothing else of the true map.
    """

    privileged: ClassVar[bool] = True

    error: float = bounded(0.0, least=0)
    """Standard deviation of the natural logarithm of reported size by true size."""
    mistaken: float = bounded(0.0, least=0)
    """Share of clusters that are reported as empty if they are not, and as not empty if they are; 0 to 1."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return InformedPilot(briefing, self)

    def provenance(self) -> dict[str, str]:
        """Return nothing, as the network is not used."""
        return {}

    def seen_maps(self) -> dict[str, list[str]]:
        """Return no maps, as the network is not used."""
        return {}


class InformedPilot(PredictivePilot):
    """Take the sizes of pockets from the true map."""

    def __init__(self, briefing: Briefing, policy: FrontierInformed) -> None:
        super().__init__(briefing, policy)
        if briefing.truth is None:
            raise InputError("expected a briefing with the true map, as privileged policies are given")
        self._truth = briefing.truth
        squares = (briefing.shape[0] // SQUARE + 1, briefing.shape[1] // SQUARE + 1)
        self._factors = np.exp(policy.error * briefing.rng.standard_normal(squares))
        self._mistaken = briefing.rng.random(squares) < policy.mistaken

    def estimates(self, view: View, clusters: Clusters) -> PocketEstimates:
        """Return the reported sizes of K clusters as certain estimates."""
        field = self.steps_from(view, view.cell)
        pockets = true_pockets(view.belief, self._truth, field, clusters, self.paths.rise)
        sizes = self.reported(pockets.sizes, clusters)
        tails = (sizes[:, None] > np.array(THRESHOLDS)).astype(np.float64)
        return PocketEstimates(tails, sizes, np.zeros(clusters.size))

    def reported(self, sizes: NDArray[np.float64], clusters: Clusters) -> NDArray[np.float64]:
        """Return the reported sizes (K,) for the true ones."""
        rows, cols = np.divmod(middles(clusters, self.paths.width, self.paths.rise), self.paths.width)
        place = rows // SQUARE, cols // SQUARE
        swapped = np.where(sizes > 0.0, 0.0, SUPPOSED)
        return np.asarray(np.where(self._mistaken[place], swapped, sizes * self._factors[place]))
