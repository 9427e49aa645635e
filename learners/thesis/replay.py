"""The thesis's replay memory: the latest transitions of all UAVs that learn, sampled uniformly."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from indoor_explorers.learners.thesis.inference import ImageFormat
from indoor_explorers.learners.thesis.observation import LEVELS


class Transitions(NamedTuple):
    """M transitions, as the memory stores them."""

    images: NDArray[np.uint8]
    """(M, K + 1, H, W) codes: the K images before the move and the one after it."""
    action: NDArray[np.int64]
    """(M,) moves."""
    reward: NDArray[np.float32]
    """(M,) rewards."""
    terminal: NDArray[np.bool_]
    """(M,) whether the move terminated the episode."""


class ThesisBatch(NamedTuple):
    """B sampled transitions."""

    image_BKHW: Tensor
    action_B: Tensor
    reward_B: Tensor
    terminal_B: Tensor
    next_image_BKHW: Tensor


class ThesisReplay:
    """Keep the last ``places`` transitions."""

    def __init__(self, places: int, image_format: ImageFormat) -> None:
        self.data = Transitions(
            images=np.zeros((places, image_format.frames + 1, image_format.height, image_format.width), np.uint8),
            action=np.zeros(places, np.int64),
            reward=np.zeros(places, np.float32),
            terminal=np.zeros(places, np.bool_),
        )
        self.written = 0

    @property
    def filled(self) -> int:
        """Number of stored transitions."""
        return min(self.written, len(self.data.action))

    def add(self, new: Transitions) -> None:
        """Write transitions over the oldest ones."""
        places = (self.written + np.arange(len(new.action))) % len(self.data.action)
        for name, store in self.data._asdict().items():
            store[places] = getattr(new, name)
        self.written += len(new.action)

    def sample(self, size: int, rng: np.random.Generator) -> ThesisBatch:
        """Draw ``size`` different transitions; ``size`` is at most :attr:`filled`."""
        chosen = rng.choice(self.filled, size, replace=False)
        levels = torch.from_numpy(LEVELS[self.data.images[chosen]])
        return ThesisBatch(
            levels[:, :-1],
            torch.from_numpy(self.data.action[chosen]),
            torch.from_numpy(self.data.reward[chosen]),
            torch.from_numpy(self.data.terminal[chosen]),
            levels[:, 1:],
        )
