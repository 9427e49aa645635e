"""PSO with estimates of what is behind the frontier."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Distances
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.swarm.pso import Pso, PsoPilot
from indoor_explorers.planners.toolbox.information.candidates import Cells
from indoor_explorers.planners.toolbox.information.prospects import Prospects
from indoor_explorers.planners.toolbox.pockets.outlook import EstimateUser


@renamed()
@dataclass(frozen=True, kw_only=True)
class PsoPredictive(EstimateUser, Pso):
    """Fly as ``pso`` does, but weigh candidates by the chance that they lead to something, and let some wait.

    A network estimates from the map around each frontier cluster how much unknown free space is behind it
    (:mod:`indoor_explorers.planners.toolbox.pockets`); a candidate leads to what the nearest cluster does
    (:mod:`indoor_explorers.planners.toolbox.information.prospects`).
    """

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return PsoPredictivePilot(briefing, self)


class PsoPredictivePilot(PsoPilot):
    """Ask what the candidates lead to."""

    def __init__(self, briefing: Briefing, policy: Pso) -> None:
        super().__init__(briefing, policy)
        self._prospects = Prospects(briefing)

    def chances(self, view: View, cells: Cells, field: Distances) -> NDArray[np.float64]:
        """Return the probability that each of (K,) flat cells leads to unknown free cells, 0 where it can wait."""
        return self._prospects.chances(view, cells, field)
