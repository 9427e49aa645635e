"""RRT frontier detection with estimates of the unknown area behind the frontier."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.sampling.rrt_frontier import RrtFrontier, RrtFrontierPilot
from indoor_explorers.planners.sampling.viewpoints import Viewpoints
from indoor_explorers.planners.toolbox.information.candidate_outlook import CandidateOutlook
from indoor_explorers.planners.toolbox.pockets.outlook import LevelEstimateUser


@renamed()
@dataclass(frozen=True, kw_only=True)
class RrtPredictive(LevelEstimateUser, RrtFrontier):
    """Fly as ``rrt-frontier`` does, but weigh candidates by the probability of unknown free cells, and defer some.

    A network estimates from the map around each frontier cluster how much unknown free space is behind it
    (:mod:`indoor_explorers.planners.toolbox.pockets`); a cell that a tree has found has the outlook of the nearest
    cluster (:mod:`indoor_explorers.planners.toolbox.information.candidate_outlook`).

    The trees: H. Umari, S. Mukhopadhyay, IROS 2017, doi:10.1109/IROS.2017.8202319. The estimates are this project's.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.as_published:
            raise InputError("expected as_published=false, got true; the paper's revenue has no place for estimates")

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return RrtPredictivePilot(briefing, self)


class RrtPredictivePilot(RrtFrontierPilot):
    """Weigh the candidates by their outlook."""

    def __init__(self, briefing: Briefing, policy: RrtPredictive) -> None:
        super().__init__(briefing, policy)
        self._candidate_outlook = CandidateOutlook(briefing, policy.estimate_files)

    def judged(self, view: View, cells: NDArray[np.int32]) -> Viewpoints:
        """Return the viewpoints among (K,) flat cells: reachable, not banned or deferred, and with a gain."""
        found = super().judged(view, cells)
        chances = self._candidate_outlook.chances(view, found.cells, self.steps_from(view, view.cell))
        return found._replace(gains=found.gains * chances).selected(chances > 0.0)
