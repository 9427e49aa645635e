"""The network's shape."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from indoor_explorers.learners.sessions.settings import Settings


class NetworkConfig(Settings):
    """The network's shape; see :mod:`indoor_explorers.learners.dddqn.network.model`."""

    encoder: Literal["none", "convolution", "attention"] = "none"
    """What the layers of the fine map go through before the first hidden layer: nothing, two layers of convolutions, or
    self-attention among its patches of 3x3 pixels (:mod:`indoor_explorers.learners.dddqn.network.encoders`)."""
    residual_blocks: int = Field(0, ge=0, le=8)
    """Residual blocks after the first hidden layer, each of two layers with a norm before them (SimBa, Lee et al.
    2025)."""
    width: int = Field(256, ge=8, le=4096)
    """Units of each hidden layer."""
    move_width: int = Field(16, ge=1, le=256)
    """Hidden units of the small network that all moves share."""
    layer_norm: bool = True
    """Layer normalisation of both hidden layers (Ba et al. 2016)."""
    dueling: bool = True
    """Q = V + A - mean A (Wang et al. 2016); if False, the last layer gives Q itself."""
    noisy: bool = False
    """Noise in the weights of the last layers (Fortunato et al. 2018), for exploration in addition to epsilon."""
    tour_cost: float = Field(0.1, ge=0.0)
    """Initial weight of the skip connection from tour features to Q: at first, each step of a move's tour beyond the
    shortest tour, to the goal and to 90 %, and each step behind the best candidate lowers Q by this much. The weight is
    learned; 0 leaves the connection out."""
    tour_pull: float = Field(0.0, ge=0.0)
    """Fixed penalty on Q, in training and in flight, for each step of a move's tour to the goal beyond the shortest
    tour and for each step behind the best candidate: among moves of similar value the UAV keeps to a tour."""
    candidates: Literal["first", "both"] = "first"
    """Kinds of candidates whose steps behind the best cost and pull: the first kind's, or both, half each. A UAV that
    is drawn to two candidates may oscillate between them."""

    @property
    def kinds(self) -> int:
        """Number of kinds of candidates that cost and pull."""
        return 2 if self.candidates == "both" else 1
