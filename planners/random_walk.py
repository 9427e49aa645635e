"""The random walk: the baseline that every planner must beat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View


@dataclass(frozen=True, kw_only=True)
class RandomWalk(Policy):
    """Move to a free neighbouring cell drawn uniformly; stay only when walled in."""

    plans_for: ClassVar[str] = "nothing"

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return RandomWalkPilot(briefing.rng)


class RandomWalkPilot(Pilot):
    """Draw each move from the pilot's own generator."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng

    def act(self, view: View) -> int:
        """Draw one of the legal moves."""
        moves = np.flatnonzero(view.legal)
        moves = moves[moves != Action.STAY]
        return int(moves[self._rng.integers(len(moves))]) if len(moves) else Action.STAY
