"""Frontier clusters in short sequences, chosen jointly by the group, against the cost of the clusters left behind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Distances, Mask
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.coordination.sequence_chooser import SequenceChooser, SequenceParameters
from indoor_explorers.planners.toolbox.information.candidates import frontier_candidates, local_candidates
from indoor_explorers.planners.toolbox.navigation.candidate_pilot import CandidatePilot
from indoor_explorers.planners.toolbox.navigation.teammates import message_of
from indoor_explorers.planners.toolbox.parameters import ReplanParameters, bounded


@renamed(fade="decay_length", rate="discount_rate", hold="goal_bonus")
@dataclass(frozen=True, kw_only=True)
class FrontierJoint(SequenceParameters, ReplanParameters, Policy):
    """Fly to the candidate with the best short sequence, minus the cost of all clusters that it leaves behind.

    Candidates are the frontier clusters, each at its cell nearest to the group, and a few cells near each UAV with
    unknown cells in view. The value of a sequence of up to three candidates is the sum of (remaining gain)^power
    e^(-discount_rate t) trust^k: the discounted gain of H. H. Gonzalez-Banos, J.-C. Latombe, IJRR 2002,
    doi:10.1177/0278364902021010834, in an orienteering problem in which each view counts once. This alone is greedy
    and leaves small pockets behind. Therefore the score of a candidate is log(value) - order * cost, with the cost of
    the best order of the UAV's own clusters that begins there, as in the travelling repairman problem (A. Blum et
    al., STOC 1994, doi:10.1145/195058.195125).

    Linked UAVs choose in turn as in W. Burgard et al., IEEE T-RO 2005, doi:10.1109/TRO.2004.839232; cells in the views
    of a sequence are worth less to UAVs that choose later. Each UAV computes all turns before its own, from the map,
    cells and goals that all of them know. :class:`OutOfContact` gives the factors for teammates out of contact.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    clusters: int = bounded(32, least=1)
    """Most frontier clusters to choose from: the nearest to any UAV of the group."""
    lookouts: int = bounded(8, least=0, tunable=(0, 16))
    """Most other candidates near each UAV, cells with unknown cells in view."""
    near: int = bounded(6, least=0, tunable=(2, 12))
    """Largest distance of these from a UAV, in steps."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return JointPilot(briefing, self)


class JointPilot(CandidatePilot):
    """Choose in turn with the linked teammates, some steps after the map has grown."""

    changes_levels: ClassVar[bool] = True
    straight = True

    def __init__(self, briefing: Briefing, policy: FrontierJoint) -> None:
        super().__init__(briefing)
        self._policy = policy
        self.replan_period = self.steps_in(policy.period)
        self.chooser = SequenceChooser(self, policy, self.candidates)
        """Chooses among the candidates."""

    def choose(self, view: View) -> Cell | None:
        """Return the candidate that this UAV gets in its turn."""
        goal = self.chooser.choose(view)
        self.message = message_of(goal)
        return goal

    def candidates(self, view: View, fields: Distances) -> tuple[NDArray[np.int32], Mask]:
        """Return flat candidate cells, (K,), and which of them are frontier clusters, (K,) bool.

        ``fields`` (N, H, W) are the steps from the UAVs of the group.
        """
        policy, reach = self._policy, float(self.briefing.lidar_range)
        ahead = frontier_candidates(view.belief, fields, reach, policy.clusters, self.paths.rise)
        around = local_candidates(
            view.belief, fields, self.lidar, policy.near, policy.discount_rate / reach, policy.lookouts
        )
        around = np.setdiff1d(around, np.concatenate([ahead, self.paths.flat(self.visited)]))
        cells = np.concatenate([ahead, around]).astype(np.int32)
        return cells, np.arange(len(cells)) < len(ahead)
