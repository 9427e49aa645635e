"""The DDDQN as a policy: dueling double deep Q-learning with shipped weights."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid import Action
from indoor_explorers.env.policy import Pilot, Policy
from indoor_explorers.env.view import Briefing, View
from indoor_explorers.learners.dddqn.inference import q_values
from indoor_explorers.learners.dddqn.observation import MOVE_FEATURES, SCENE, observe, remember
from indoor_explorers.learners.dddqn.sensor import scratch, sensor
from indoor_explorers.learners.dddqn.weights import SHIPPED, acting_weights
from indoor_explorers.learners.guard import Guard


@dataclass(frozen=True, kw_only=True)
class Dddqn(Policy):
    """Explore with a dueling double deep Q-network.

    Mnih et al. 2015, doi:10.1038/nature14236; van Hasselt, Guez and Silver 2016, arXiv:1509.06461; Wang et
    al. 2016, arXiv:1511.06581. The UAV makes the legal move of highest value, and stays where it is only
    when nothing within its reach is unknown. Deterministic but for the guard's back-off.

    Raises:
        InputError: ``weights`` is missing or holds something else.

    """

    weights: str | None = None
    """Path of a safetensors file from training; None: the weights that ship."""
    guard: bool = True
    """Hand over to the nearest frontier while the network goes nowhere."""

    def __post_init__(self) -> None:
        acting_weights(self._path)

    @property
    def _path(self) -> Path:
        return SHIPPED if self.weights is None else Path(self.weights)

    def provenance(self) -> dict[str, str]:
        """Return the hash of the weights."""
        return {"weights_sha256": hashlib.sha256(self._path.read_bytes()).hexdigest()}

    def pilot(self, briefing: Briefing) -> DddqnPilot:
        """Make the mind of one UAV for one episode."""
        return DddqnPilot(self, briefing)

    def act(self, pilots: Sequence[Pilot], views: Sequence[View]) -> list[int]:
        """Choose for many UAVs with one forward pass; each choice is what it would be alone."""
        scene_BS = np.empty((len(pilots), SCENE), np.uint8)
        moves_BAF = np.empty((len(pilots), 4, len(MOVE_FEATURES)), np.float32)
        q_BA = np.empty((len(pilots), 4), np.float32)
        minds = cast("Sequence[DddqnPilot]", pilots)
        for mind, view, scene_S, moves_AF in zip(minds, views, scene_BS, moves_BAF, strict=True):
            mind.perceive(view, scene_S, moves_AF)
        q_values(scene_BS, moves_BAF, acting_weights(self._path), q_BA)
        return [mind.decide(view, q_A) for mind, view, q_A in zip(minds, views, q_BA, strict=True)]


class DddqnPilot(Pilot):
    """Remember where one UAV has been since its last gain."""

    def __init__(self, policy: Dddqn, briefing: Briefing) -> None:
        self._policy = policy
        self._sensor = sensor(briefing.lidar_range)
        self._scratch = scratch(briefing.shape, self._sensor)
        self._noted = np.zeros(briefing.shape, np.uint8)
        self._visits = np.zeros(briefing.shape, np.uint8)
        self._gained = 0
        self._nearest = -1
        self._guard = Guard(briefing.shape, briefing.rng) if policy.guard else None

    def act(self, view: View) -> int:
        """Choose alone."""
        return self._policy.act([self], [view])[0]

    def perceive(self, view: View, scene_S: NDArray[np.uint8], moves_AF: NDArray[np.float32]) -> None:
        """Write the observation into ``scene_S`` (696,) and ``moves_AF`` (4, 8)."""
        row, col = view.cell
        self._gained += remember(view.belief, row, col, self._sensor, self._noted, self._visits)
        self._nearest = observe(view.belief, row, col, self._visits, self._sensor, self._scratch, scene_S, moves_AF)

    def decide(self, view: View, q_A: NDArray[np.float32]) -> int:
        """Choose by the values ``q_A`` (4,) of the moves."""
        legal_A = view.legal[:4]
        if self._nearest < 0 or not legal_A.any():
            if self._guard is not None:
                self._guard.rest()
            return Action.STAY
        proposal = int(np.where(legal_A, q_A, -np.inf).argmax())
        return proposal if self._guard is None else self._guard.review(view, self._gained, proposal)

    def tally(self) -> dict[str, float]:
        """Return ``guarded_share``, the share of the decisions that the guard took over."""
        return {} if self._guard is None else {"guarded_share": self._guard.share}
