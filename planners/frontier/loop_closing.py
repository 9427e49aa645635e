"""Active loop closing: where the pose drifts, fly to where it is corrected, and look again at what is wrong."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot
from indoor_explorers.env.policies.view import Briefing
from indoor_explorers.planners.toolbox.explorers import ExploringWith
from indoor_explorers.planners.toolbox.localisation.loops import DOUBT, SCAN_COST, LoopPilot
from indoor_explorers.planners.toolbox.parameters import bounded


@dataclass(frozen=True, kw_only=True)
class LoopClosing(ExploringWith):
    """Explore as another policy does, close a loop as soon as the pose is probably wrong, and mend the map at the end.

    Each UAV estimates its path from its own scans (:class:`~.trajectory.Trajectory`), and so where it really is, when
    it slipped, and which cells the map shows wrongly. As in C. Stachniss, D. Haehnel, W. Burgard, "Exploration with
    active loop-closing for FastSLAM", IROS 2004, doi:10.1109/IROS.2004.1389691, it interrupts the exploration to
    return to a known place; but by the probability that its pose is wrong, not by the pose's variance, which grows
    although nothing has happened. Among the places, the expected loss decides, as the information gain of map and pose
    does in C. Stachniss, G. Grisetti, W. Burgard, RSS 2005, doi:10.15607/RSS.2005.I.009: the steps there, and the
    scans that the correction leaves in the wrong place, as it is spread over the path with its middle where it may.
    Where nothing drifts, UAVs fly as the explorer.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    doubt: float = bounded(DOUBT, least=0.01, most=0.99, tunable=(0.1, 0.9))
    """Probability of a wrong pose from which on a UAV takes it for wrong."""
    scan_cost: float = bounded(SCAN_COST, least=0, tunable=(0.1, 10.0, "log"))
    """Cost of a scan that a correction would leave in the wrong place, in steps."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        explorer = self.make_explorer()
        return LoopPilot(briefing, explorer, explorer.pilot(briefing), self.doubt, self.scan_cost)
