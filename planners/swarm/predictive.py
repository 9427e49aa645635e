"""PSO with estimates of the unknown area behind the frontier."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Distances
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.swarm.pso import Pso, PsoPilot
from indoor_explorers.planners.toolbox.information.candidate_outlook import CandidateOutlook
from indoor_explorers.planners.toolbox.information.candidates import Cells
from indoor_explorers.planners.toolbox.pockets.outlook import LevelEstimateUser


@renamed()
@dataclass(frozen=True, kw_only=True)
class PsoPredictive(LevelEstimateUser, Pso):
    """Fly as ``pso`` does, but weigh candidates by the probability of unknown free cells, and defer some.

    A network estimates from the map around each frontier cluster how much unknown free space is behind it
    (:mod:`indoor_explorers.planners.toolbox.pockets`); a candidate has the outlook of the nearest cluster
    (:mod:`indoor_explorers.planners.toolbox.information.candidate_outlook`).

    The swarm: J. Kennedy, R. Eberhart, ICNN 1995, doi:10.1109/ICNN.1995.488968. The estimates are this project's.
    """

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return PsoPredictivePilot(briefing, self)


class PsoPredictivePilot(PsoPilot):
    """Weigh the candidates by their outlook."""

    def __init__(self, briefing: Briefing, policy: PsoPredictive) -> None:
        super().__init__(briefing, policy)
        self._candidate_outlook = CandidateOutlook(briefing, policy.estimate_files)

    def chances(self, view: View, cells: Cells, field: Distances) -> NDArray[np.float64]:
        """Return the probability that each of (K,) flat cells leads to unknown free cells, 0 where it can wait."""
        return self._candidate_outlook.chances(view, cells, field)
