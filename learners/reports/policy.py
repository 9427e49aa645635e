"""The policy ``dddqn-reports``, whose UAVs explore as those of another one and fly home when a network values it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from indoor_explorers.env.policies.explanation import Explanation
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.provenance import joined, record_of, recorded_maps
from indoor_explorers.learners.reports.network import NetworkWeights, load_weights, value
from indoor_explorers.learners.reports.situation import LATE_COST, Situation, SituationObserver
from indoor_explorers.learners.sessions.record import digest_of
from indoor_explorers.planners.toolbox.explorers import ExploringWith
from indoor_explorers.planners.toolbox.networks.weights_file import weights_path
from indoor_explorers.planners.toolbox.pockets.estimates import DEFAULT_FILES, EstimateFiles
from indoor_explorers.planners.toolbox.pockets.outlook import LevelEstimateUser
from indoor_explorers.planners.toolbox.reporting import ReportingPilot

#: The weights that ship.
SHIPPED = Path(__file__).parent / "weights" / "reports.safetensors"
#: The file of the weights in the folder of a training.
NAME = "reports.safetensors"


class ReportsPilot(ReportingPilot):
    """Choose once in a lidar range of flight whether to fly home."""

    def __init__(
        self,
        briefing: Briefing,
        explorer: Policy,
        pilot: Pilot,
        weights: NetworkWeights,
        late_cost: float = LATE_COST,
        files: EstimateFiles = DEFAULT_FILES,
    ) -> None:
        super().__init__(briefing, explorer, pilot)
        self._weights, self._observer = weights, SituationObserver(self, late_cost, files)
        self._period, self._next = max(1, int(briefing.lidar_range)), 0
        self._valued = ""

    def act(self, view: View) -> int:
        """Explore, or fly home."""
        action = super().act(view)
        if self.reports:
            self._observer.note()
        return action

    def is_worth_it(self, view: View) -> bool:
        """Tell whether the network values flying home more than exploring on."""
        if view.step < self._next:
            return False
        self._next = view.step + self._period
        return self.pick(view, self._observer.observe(view))

    def pick(self, view: View, situation: Situation) -> bool:
        """Return the choice in a situation."""
        worth = value(situation, self._weights)
        if self.explaining:
            self._valued = f"at step {view.step} flying home had the value {worth:.2f}, exploring on 0"
        return worth > 0.0

    def explain(self) -> Explanation | None:
        """Return what the rule and the explorer explain, with the latest value of flying home."""
        found = super().explain()
        return found and replace(found, note="; ".join(filter(None, (found.note, self._valued))))


@dataclass(frozen=True, kw_only=True)
class DddqnReports(LevelEstimateUser, ExploringWith):
    """Explore as another policy does, and report to a home base when a dueling network values it.

    Once in a lidar range of flight the network compares flying home with exploring on, from 25 numbers about what is
    known, unreported, expected and left of the time (:mod:`indoor_explorers.learners.reports.situation`). Of UAVs in
    contact only the one nearest to the base flies home, and all are there before the deadline
    (:mod:`indoor_explorers.planners.toolbox.reporting`). Where there is no base, UAVs fly as the explorer.

    It is trained by policy iteration with double and dueling estimates
    (:mod:`indoor_explorers.learners.reports.learning`), begun as ``return-to-base(when="worth")``. Double estimation:
    H. van Hasselt, "Double Q-learning", NeurIPS 2010; dueling networks: Wang et al. 2016, arXiv:1511.06581;
    advantages: Schulman et al. 2016, arXiv:1506.02438, and Pan et al. 2022, arXiv:2109.06093.

    Raises:
        InputError: ``weights`` is missing or not a file of this network.

    """

    plans_for: ClassVar[str] = ALL_CELLS

    explorer: str = "frontier-predictive"
    """Registry name of the policy that explores."""
    weights: str | None = None
    """Path of a training's folder or weights; None: the shipped ones."""

    def __post_init__(self) -> None:
        super().__post_init__()
        load_weights(self.path)

    @property
    def path(self) -> Path:
        """The path of the weights."""
        return weights_path(self.weights, SHIPPED, NAME)

    def pilot(self, briefing: Briefing) -> ReportsPilot:
        """Make the pilot of one UAV for one episode."""
        explorer = self.make_explorer()
        weights, pilot = load_weights(self.path), explorer.pilot(briefing)
        return ReportsPilot(briefing, explorer, pilot, weights, files=self.estimate_files)

    def provenance(self) -> dict[str, str]:
        """Return the hashes of the network's weights and of those of the estimates, and what the explorer declares."""
        others = LevelEstimateUser.provenance(self) | ExploringWith.provenance(self)
        return others | {"reports_sha256": digest_of(self.path)}

    def seen_maps(self) -> dict[str, list[str]]:
        """Return the maps that the network, the estimates and the explorer were learned from."""
        others = [LevelEstimateUser.seen_maps(self), ExploringWith.seen_maps(self)]
        return joined([*others, recorded_maps(record_of(self.path))])


def opened(path: str, **parameters: Any) -> DddqnReports:
    """Return the policy of a trained network, ``dddqn-reports:DIR``."""
    return DddqnReports(weights=path, **parameters)
