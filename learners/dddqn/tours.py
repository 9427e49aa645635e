"""The policy ``tours``: the planner features of the DDDQN, flown by a rule without its network."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.policies.policy import Policy
from indoor_explorers.env.policies.view import Briefing
from indoor_explorers.env.search.bitsets import ROOM
from indoor_explorers.learners.dddqn.observation.config import WIDEST, ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import observation_layout, search_costs
from indoor_explorers.learners.dddqn.observation.map_prior import no_prior, prior_from
from indoor_explorers.learners.dddqn.pilot import ObservingPilot
from indoor_explorers.learners.dddqn.weights import load_weights, shipped
from indoor_explorers.learners.sessions.record import RecordedWeights, digest_of

#: The shipped weights whose map prior is used; their network is not.
PRIOR_OF = "thesis-obstacles"


@dataclass(frozen=True, kw_only=True)
class Tours(RecordedWeights, Policy):
    """Begin the shortest tour to 99 % coverage that a beam search finds; on large maps, fly to the best viewpoint.

    Among moves with equally short tours it makes the one whose tour sees cells soonest; with ``delay``, it trades steps
    to 99 % for steps to 90 %. These are the planner features of the DDDQN without its network: the benefit of learning
    is measured against them. Maps of up to 16x16 cells are searched
    (:mod:`indoor_explorers.learners.dddqn.observation.tours`); on larger ones the UAV flies to the frontier cell with
    the best view gain for its distance (:mod:`indoor_explorers.learners.dddqn.observation.candidates`). Everything but
    the guard's back-off is deterministic.

    Raises:
        InputError: ``states`` or ``delay`` is out of range.

    """

    plans_for: ClassVar[str] = "99 % in rooms, all cells elsewhere"

    states: int = 32
    """Beam width: states kept at each step; a wider beam finds shorter tours and takes longer."""
    delay: float = 0.0
    """Cost of each step for which one cell stays unseen longer than necessary, in steps of the tour; 0: delay decides
    between equally short tours only."""
    map_prior: bool = True
    """Whether tours avoid likely obstacles by the learned map prior, the only learned part; else every unknown cell
    counts as free."""
    guard: bool = True
    """Fly to the nearest frontier while there is no progress."""

    def __post_init__(self) -> None:
        if self.states not in range(1, WIDEST + 1):
            raise InputError(f"expected states from 1 to {WIDEST}, got {self.states!r}")
        if not 0.0 <= self.delay <= 1.0:
            raise InputError(f"expected delay from 0 to 1, got {self.delay!r}")

    def observation(self, shape: tuple[int, int]) -> ObservationConfig:
        """Return the observation on (H, W) maps: tours or candidates, and the smallest possible map image."""
        room = max(shape) <= ROOM
        return ObservationConfig(
            crop=3,
            layers=("unknown",),
            coarse=0,
            sides=False,
            visits=False,
            gains=False,
            tours=room,
            tour_width=self.states,
            prospects=not room,
        )

    def provenance(self) -> dict[str, str]:
        """Return the hash of the weights that hold the map prior."""
        return {"map_prior_sha256": digest_of(shipped()[PRIOR_OF])} if self.map_prior else {}

    def weights_paths(self) -> list[Path]:
        """Return the path of the weights whose training fitted the map prior."""
        return [shipped()[PRIOR_OF]]

    def pilot(self, briefing: Briefing) -> ToursPilot:
        """Make the pilot of one UAV for one episode."""
        return ToursPilot(self, briefing)


class ToursPilot(ObservingPilot):
    """Value the moves by the tours, or the candidates, behind them."""

    def __init__(self, policy: Tours, briefing: Briefing) -> None:
        observation = policy.observation(briefing.shape)
        prior = prior_from(load_weights(shipped()[PRIOR_OF]).prior) if policy.map_prior else no_prior()
        super().__init__(briefing, observation, prior, guard=policy.guard)
        costs = search_costs(observation_layout(observation), policy.delay)
        assert costs is not None
        self._costs = costs

    def _values(self) -> NDArray[np.float32]:
        return np.asarray((self.moves[0] * self._costs).sum(axis=1), np.float32)
