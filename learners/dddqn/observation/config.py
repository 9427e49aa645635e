"""The settings of the network's input; most of the shipped weights use the defaults."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, field_validator

from indoor_explorers.learners.sessions.settings import Settings

#: Layers of the fine map, in the order in which they are written.
Layer = Literal["unknown", "free", "chance", "visits", "frontier", "distance", "mates", "mates_past"]
LAYERS: tuple[Layer, ...] = ("unknown", "free", "chance", "visits", "frontier", "distance", "mates", "mates_past")
#: Largest beam width of the search for tours.
WIDEST = 1024


class ObservationConfig(Settings):
    """The network's input from one UAV's belief; see :mod:`indoor_explorers.learners.dddqn.observation.observe`."""

    crop: int = Field(15, ge=3, le=63)
    """Side of the fine map around the UAV in pixels, odd."""
    layers: tuple[Layer, ...] = ("unknown", "free", "chance")
    """Layers of the fine map: ``unknown`` cells, known ``free`` cells, ``chance``, the probability by the learned map
    prior that an unknown cell is free and reachable, ``visits`` since the last gain, ``frontier`` cells, ``distance``
    to the nearest frontier cell, ``mates`` heard in this step, and ``mates_past``, heard before and fading with age."""
    coarse: int = Field(11, ge=0, le=31)
    """Side of the coarse map around the UAV in blocks of 3x3 pixels, odd; 0 leaves it out."""
    sides: bool = True
    """Numbers of unknown cells below, left of, above and right of the UAV."""
    identity: bool = False
    """The UAV's number, one of eight, so that linked UAVs with the same map can act differently (Terry et al. 2020)."""
    progress: bool = False
    """Known share of the map, share of the step budget used, and steps since the last gain."""
    frames: int = Field(1, ge=1, le=8)
    """Number of stacked scenes (Mnih et al. 2015)."""
    visits: bool = True
    """For each move: visits of the next cell since the last gain."""
    gains: bool = True
    """For each move: the view gain of the next cell, the distance to the nearest gain, and discounted gains ahead."""
    tours: bool = True
    """For each move: the tours that a beam search finds behind it, in rooms of up to 16x16 cells."""
    tour_width: int = Field(8, ge=1, le=WIDEST)
    """Width of this beam: a wider one finds shorter tours and takes longer."""
    division: bool = False
    """Tours leave to linked teammates parts of the room with equally long tours, and keep to that division without
    contact (:mod:`indoor_explorers.learners.dddqn.observation.division`); else the cells that those are closer to."""
    prospects: bool = False
    """For each move, on maps of any size: how far it is behind the move to the best candidate viewpoint, by view gain
    and path length; once with plain gains and once with isolated cells weighted more."""

    @field_validator("crop", "coarse")
    @classmethod
    def _odd(cls, value: int) -> int:
        if value and value % 2 == 0:
            raise ValueError("expected an odd number, so that the UAV is in the middle")
        return value

    @field_validator("layers")
    @classmethod
    def _in_order(cls, value: tuple[Layer, ...]) -> tuple[Layer, ...]:
        if not value:
            raise ValueError("expected at least one layer")
        return tuple(layer for layer in LAYERS if layer in value)
