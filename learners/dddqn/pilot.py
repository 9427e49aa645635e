"""Pilots that observe one UAV's surroundings and make the legal move of highest value."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.policies.explanation import of_moves
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.learners.dddqn.network.inference import q_values
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import BLOCKED_AT, move_parts, observation_layout, stacked
from indoor_explorers.learners.dddqn.observation.map_prior import MapPrior, prior_from
from indoor_explorers.learners.dddqn.observation.memory import new_memory
from indoor_explorers.learners.dddqn.observation.observe import observation_context, observe
from indoor_explorers.learners.dddqn.observation.uav import Known
from indoor_explorers.learners.dddqn.weights import LoadedWeights
from indoor_explorers.learners.guard import GuardedPilot


class ObservingPilot(GuardedPilot):
    """Observe and act for one UAV, with the memory that its observation needs; subclasses value the moves."""

    def __init__(self, briefing: Briefing, observation: ObservationConfig, prior: MapPrior, *, guard: bool) -> None:
        super().__init__(briefing, guard=guard)
        layout = observation_layout(observation)
        self._context = observation_context(observation, briefing.shape, briefing.scenario, prior)
        self._memory = new_memory(1, briefing.shape, observation, briefing.team)
        self._scene = np.zeros((1, layout.scene), np.uint8)
        self.scenes = np.zeros((1, layout.inputs), np.uint8)
        self.moves = np.zeros((1, 4, layout.features), np.float32)
        self._mates = np.zeros((1, briefing.team, 2), np.int64)
        self._ages = np.full((1, briefing.team), -1)
        self._agent, self._flown = np.array([briefing.agent]), np.zeros(1)
        self._cell = np.zeros((1, 2), np.int64)
        self._layout = layout

    @abstractmethod
    def _values(self) -> NDArray[np.float32]:
        """Return the values (4,) float32 of the moves by the latest observation."""

    def act(self, view: View) -> int:
        """Make the legal move of highest value."""
        self._observe(view)
        action = self._choose(view)
        if self.explaining:
            worth = np.where(self.moves[0, :, BLOCKED_AT] == 0.0, self._values(), -np.inf)
            self.kept = of_moves(view, action, worth, "value of the move", move_parts(self._layout, self.moves[0]))
        self._memory.aim(self._cell, np.array([action]))
        return action

    def _choose(self, view: View) -> int:
        legal_A = self.moves[0, :, BLOCKED_AT] == 0.0
        if not legal_A.any():  # contested cells count as blocked: see observe
            legal_A = view.legal[:4]
        if self._memory.nearest[0] < 0 or not legal_A.any():
            if self._guard is not None:
                self._guard.rest()
            return Action.STAY
        proposal = int(np.where(legal_A, self._values(), -np.inf).argmax())
        return proposal if self._guard is None else self._guard.review(view, int(self._memory.gained[0]), proposal)

    def _observe(self, view: View) -> None:
        self._cell[0] = view.cell
        self._flown[0] = view.step / view.budget
        for mate in view.mates:
            self._mates[0, mate.agent], self._ages[0, mate.agent] = mate.cell, mate.age
        known = Known(view.belief[None], self._cell, self._mates, self._ages, self._agent, self._flown)
        observe(known, self._memory, _ONLY, self._context, self._scene, self.moves)
        self.scenes = stacked(self._scene, self.scenes, np.array([view.step == 0]))


class DddqnPilot(ObservingPilot):
    """Value the moves by a network."""

    def __init__(self, briefing: Briefing, loaded: LoadedWeights, *, guard: bool, other_range: bool) -> None:
        super().__init__(briefing, loaded.observation, prior_from(loaded.prior), guard=guard)
        self._weights = loaded.weights
        self._q: NDArray[np.float32] = np.zeros((1, 4), np.float32)
        self._tally = {"other_range": 1.0} if other_range else {}

    def _values(self) -> NDArray[np.float32]:
        q_values(self.scenes, self.moves, self._weights, self._q)
        return self._q.ravel()

    def tally(self) -> dict[str, float]:
        """Return the tally of every such pilot, and ``other_range``.

        ``other_range`` is 1 where the weights were not trained with the scenario's lidar range.
        """
        return self._tally | super().tally()


_ONLY: NDArray[np.int64] = np.zeros(1, np.int64)
