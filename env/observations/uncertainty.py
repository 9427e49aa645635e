"""What a UAV knows where sensors or poses err: probabilities instead of a certain map, and its heading."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from indoor_explorers.env.observations.base import Encoder
from indoor_explorers.env.policies.view import Briefing, View


@dataclass(frozen=True)
class Occupancy:
    """The probability that each cell is occupied, (1, H, W) float32: see :attr:`View.occupancy`."""

    def __call__(self, briefing: Briefing) -> OccupancyEncoder:
        """Make the encoder of one UAV."""
        return OccupancyEncoder(briefing)


class OccupancyEncoder(Encoder):
    """Encode :class:`Occupancy`."""

    stateless = True

    def __init__(self, briefing: Briefing) -> None:
        self.space = Box(0.0, 1.0, (1, *briefing.shape), np.float32)

    def encode(self, view: View, out: NDArray[np.float32]) -> None:
        """Write one view's probabilities."""
        out[0] = view.occupancy


@dataclass(frozen=True)
class Heading:
    """The direction that the UAV faces, (4,) float32: 1 for down, left, up or right; zeros where it sees all around."""

    def __call__(self, briefing: Briefing) -> HeadingEncoder:
        """Make the encoder of one UAV."""
        return HeadingEncoder()


class HeadingEncoder(Encoder):
    """Encode :class:`Heading`."""

    stateless = True

    def __init__(self) -> None:
        self.space = Box(0.0, 1.0, (4,), np.float32)

    def encode(self, view: View, out: NDArray[np.float32]) -> None:
        """Write one view's heading."""
        out[:] = 0.0
        if view.heading is not None:
            out[view.heading] = 1.0
