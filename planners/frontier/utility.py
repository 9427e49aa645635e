"""Utility: the expected gain of a frontier cluster against the path to it, in three forms from the literature."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.frontier.burgard import SequentialParameters, SequentialPilot
from indoor_explorers.planners.frontier.group_pilot import ClusterChoices
from indoor_explorers.planners.toolbox.information.view_gain import unclaimed_gains
from indoor_explorers.planners.toolbox.parameters import bounded, one_of

#: How gain and cost are combined to a score.
Form = Literal["size", "difference", "discounted"]


@renamed(hold="switch_cost")
@dataclass(frozen=True, kw_only=True)
class FrontierUtility(SequentialParameters, Policy):
    """Fly to the frontier cluster with the best score of gain against path length d; R is the lidar range.

    ``size`` is s - c d, s the cluster's number of cells: explore_lite's rule (J. Hörner, "Map-merging for multi-robot
    system", Charles University 2016). ``difference`` is g - c R d and ``discounted`` g exp(-c d / R), g the number of
    unknown cells in view: H. H. Gonzalez-Banos, J.-C. Latombe, "Navigation strategies for exploring indoor
    environments", IJRR 21, 2002, doi:10.1177/0278364902021010834. Teams take the clusters in turn as in
    :mod:`indoor_explorers.planners.frontier.burgard`.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    form: Form = one_of("size", get_args(Form), tunable=True)
    """Form of the score: ``size``, ``difference`` or ``discounted``."""
    cost: float = bounded(3.0, least=0, tunable=(0.3, 30.0, "log"))
    """Weight c of the path length in the form; 3 suits all three."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return UtilityPilot(briefing, self)


class UtilityPilot(SequentialPilot):
    """Score pairs of UAV and cluster by gain and cost."""

    def __init__(self, briefing: Briefing, policy: FrontierUtility) -> None:
        super().__init__(briefing, policy.switch_cost, policy.weight, policy.reach)
        self._policy = policy

    def gains(self, view: View, choices: ClusterChoices) -> NDArray[np.float64]:
        """Return each cluster's size, or the unknown cells in view of its cell nearest to any UAV, (K,)."""
        if self._policy.form == "size":
            return np.diff(choices.clusters.ends)[choices.numbers].astype(np.float64)
        places, no_claims = choices.viewpoints(), np.empty((0, 2))
        return unclaimed_gains(view.belief, places, no_claims, self.lidar).astype(np.float64)

    def score(self, gains: NDArray[np.float64], costs: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the scores (N, K) of pairs of UAV and cluster."""
        weight, reach = self._policy.cost, self.briefing.lidar_range
        if self._policy.form == "discounted":
            return gains * np.exp(-weight / reach * np.minimum(costs, UNREACHABLE))
        return gains - weight * (reach if self._policy.form == "difference" else 1.0) * costs
