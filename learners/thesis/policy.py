"""The thesis's DDDQN as a policy: greedy, with its own network and observation."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.files import expanded
from indoor_explorers.env.policies.explanation import of_moves
from indoor_explorers.env.policies.policy import TRAINED_GOAL, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.learners.guard import WatchedPilot
from indoor_explorers.learners.sessions.record import RecordedWeights, digest_of
from indoor_explorers.learners.thesis.inference import MOVES, SHIPPED, ImageFormat, q_values, trained
from indoor_explorers.learners.thesis.observation import LEVELS, centred, painted, window


@dataclass(frozen=True, kw_only=True)
class DddqnThesis(RecordedWeights, Policy):
    """Explore with the DDDQN of the IndoorExplorers thesis: its network, its image of the map, greedily.

    It makes the move of highest value, also into walls, as in the thesis. On maps larger than the training maps it
    sees a window of their size around the UAV. What the thesis built on: Mnih et al. 2015, doi:10.1038/nature14236; van
    Hasselt, Guez and Silver 2016, arXiv:1509.06461; Wang et al. 2016, arXiv:1511.06581.

    Raises:
        InputError: ``weights`` is missing or not a file of this network.

    """

    plans_for: ClassVar[str] = TRAINED_GOAL

    weights: str | None = None
    """Path of a safetensors file from training; None: the weights that ship."""
    mask: bool = False
    """Choose among legal moves only, so that the UAV hits no wall; the thesis: False."""
    guard: bool = False
    """Fly to the nearest frontier while the network makes no progress; the thesis: False."""

    def __post_init__(self) -> None:
        trained(self.path)

    @property
    def path(self) -> Path:
        """Path of the weights."""
        return SHIPPED if self.weights is None else expanded(self.weights)

    @property
    def image_format(self) -> ImageFormat:
        """Format of the images that the network sees."""
        return trained(self.path).image_format

    def provenance(self) -> dict[str, str]:
        """Return the hash of the weights."""
        return {"weights_sha256": digest_of(self.path)}

    def weights_paths(self) -> list[Path]:
        """Return the path of the weights."""
        return [self.path]

    def pilot(self, briefing: Briefing) -> DddqnThesisPilot:
        """Make the pilot of one UAV for one episode."""
        return DddqnThesisPilot(self, briefing)


class DddqnThesisPilot(WatchedPilot):
    """Stack the latest images of one UAV, and make the move of highest value."""

    def __init__(self, policy: DddqnThesis, briefing: Briefing) -> None:
        super().__init__(briefing, guard=policy.guard)
        self._trained, self._mask, self._agent = trained(policy.path), policy.mask, briefing.agent
        image_format = self._trained.image_format
        self._past: deque[NDArray[np.uint8]] = deque(maxlen=image_format.frames)
        self._images_BKHW = np.empty((1, image_format.frames, image_format.height, image_format.width), np.uint8)
        self._q_BA = np.empty((1, MOVES), np.float32)

    def act(self, view: View) -> int:
        """Make the move of highest value."""
        self.perceive(view, self._images_BKHW[0])
        q_values(self._images_BKHW, LEVELS, self._trained.weights, self._q_BA)
        q_A = self._q_BA[0]
        if self._mask and view.legal[:MOVES].any():
            q_A = np.where(view.legal[:MOVES], q_A, -np.inf)
        action = self.review(view, int(q_A.argmax()))
        if self.explaining:
            self.kept = of_moves(view, action, q_A, "value of the move", {})
        return action

    def perceive(self, view: View, out: NDArray[np.uint8]) -> None:
        """Write the latest images into ``out`` (K, H, W), the latest last; at first, the first one K times."""
        image_format = self._trained.image_format
        image = painted(view, self._agent, identity=image_format.identity)
        if image_format.centred:
            image = centred(image, view.cell, out.shape[1:])
        self._past.append(image)
        while len(self._past) < image_format.frames:
            self._past.append(self._past[-1])
        if image_format.centred:
            out[:] = self._past
        else:
            window(self._past, view.cell, out.shape[1:], out)
