"""The network's shape."""

from __future__ import annotations

from pydantic import Field

from indoor_explorers.learners.sessions.settings import Settings


class NetworkConfig(Settings):
    """The network's shape; see :mod:`indoor_explorers.learners.dddqn.network.model`."""

    width: int = Field(256, ge=8, le=4096)
    """Units of both hidden layers."""
    move_width: int = Field(16, ge=1, le=256)
    """Hidden units of the small net that all moves share."""
    layer_norm: bool = True
    """Normalise both hidden layers (Ba et al. 2016)."""
    dueling: bool = True
    """Q = V + A - mean A (Wang et al. 2016); without, the last layer gives Q itself."""
    noisy: bool = False
    """Explore by noise in the weights of the last layers (Fortunato et al. 2018) on top of epsilon."""
    tour_cost: float = Field(0.1, ge=0.0)
    """Initial weight of the skip connection from tour features to Q: each step that a move's tour takes beyond the
    shortest, to the goal and to 90 %, costs this much at first, and so does each step behind the best prospect. Learned
    from there; 0 begins without."""
    tour_pull: float = Field(0.0, ge=0.0)
    """Fixed cost of each step that a move's tour to the goal takes beyond the shortest, and of each step behind the
    best prospect, subtracted from Q in training and in flight: among moves of about equal value the UAV keeps to a
    tour."""
