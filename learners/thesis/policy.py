"""The thesis's learner as a policy: greedy, by its own network and observation."""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, cast

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.learners.guard import WatchedPilot
from indoor_explorers.learners.thesis.inference import q_values
from indoor_explorers.learners.thesis.observation import LEVELS, painted, window
from indoor_explorers.learners.thesis.sizes import MOVES, Eye
from indoor_explorers.learners.thesis.weights import SHIPPED, trained


@dataclass(frozen=True, kw_only=True)
class DddqnThesis(Policy):
    """Explore with the DDDQN of the IndoorExplorers thesis: its network, its image of the map, greedily.

    It makes the move of highest value, into walls too, as the thesis's did. Larger maps than that of its
    training it sees through a window of that size around the UAV.

    Raises:
        InputError: ``weights`` is missing or holds something else.

    """

    weights: str | None = None
    """Path of a safetensors file from training; None: the weights that ship."""
    mask: bool = False
    """Choose among legal moves alone, so that no wall is hit; the thesis: no."""
    guard: bool = False
    """Hand over to the nearest frontier while the network goes nowhere; the thesis: no."""

    batched: ClassVar[bool] = True

    def __post_init__(self) -> None:
        trained(self._path)

    @property
    def _path(self) -> Path:
        return SHIPPED if self.weights is None else Path(self.weights)

    @property
    def eye(self) -> Eye:
        """What the network sees."""
        return trained(self._path).eye

    def provenance(self) -> dict[str, str]:
        """Return the hash of the weights."""
        return {"weights_sha256": hashlib.sha256(self._path.read_bytes()).hexdigest()}

    def pilot(self, briefing: Briefing) -> DddqnThesisPilot:
        """Make the mind of one UAV for one episode."""
        return DddqnThesisPilot(self, briefing)

    def act(self, pilots: Sequence[Pilot], views: Sequence[View]) -> list[int]:
        """Choose for many UAVs with one forward pass; each choice is what it would be alone."""
        eye, weights = trained(self._path)
        images_BKHW = np.empty((len(pilots), eye.frames, eye.height, eye.width), np.uint8)
        q_BA = np.empty((len(pilots), MOVES), np.float32)
        minds = cast("Sequence[DddqnThesisPilot]", pilots)
        for mind, view, images_KHW in zip(minds, views, images_BKHW, strict=True):
            mind.perceive(view, images_KHW)
        q_values(images_BKHW, LEVELS, weights, q_BA)
        return [mind.review(view, self._choice(view, q_A)) for mind, view, q_A in zip(minds, views, q_BA, strict=True)]

    def _choice(self, view: View, q_A: NDArray[np.float32]) -> int:
        if self.mask and view.legal[:MOVES].any():
            q_A = np.where(view.legal[:MOVES], q_A, -np.inf)
        return int(q_A.argmax())


class DddqnThesisPilot(WatchedPilot):
    """Remember the latest images of one UAV."""

    def __init__(self, policy: DddqnThesis, briefing: Briefing) -> None:
        super().__init__(briefing, guard=policy.guard)
        self._policy, self._agent, self._eye = policy, briefing.agent, policy.eye
        self._images: deque[NDArray[np.uint8]] = deque(maxlen=self._eye.frames)

    def act(self, view: View) -> int:
        """Choose alone."""
        return self._policy.act([self], [view])[0]

    def perceive(self, view: View, out: NDArray[np.uint8]) -> None:
        """Write the latest images into ``out`` (K, H, W); before the first move, the first one K times."""
        self._images.append(painted(view, self._agent, identity=self._eye.identity))
        while len(self._images) < self._eye.frames:
            self._images.append(self._images[-1])
        window(self._images, view.cell, out.shape[1:], out)
