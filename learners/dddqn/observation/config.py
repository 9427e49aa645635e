"""What the network sees, switch by switch; the defaults made most of the weights that ship."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, field_validator

from indoor_explorers.learners.sessions.settings import Settings

#: Layers that the fine map may have, in the order in which they are written.
Layer = Literal["unknown", "free", "chance", "visits", "frontier", "distance", "mates", "mates_past"]
LAYERS: tuple[Layer, ...] = ("unknown", "free", "chance", "visits", "frontier", "distance", "mates", "mates_past")
#: States that the search for tours may keep at each step.
WIDEST = 1024


class ObservationConfig(Settings):
    """What the network sees of one UAV's belief; see :mod:`indoor_explorers.learners.dddqn.observation.observe`."""

    crop: int = Field(15, ge=3, le=63)
    """Pixels a side of the fine map around the UAV, odd."""
    layers: tuple[Layer, ...] = ("unknown", "free", "chance")
    """What the fine map shows: ``unknown`` and known ``free`` cells, the ``chance`` of unknown cells to count by the
    learned map prior, ``visits`` since the last gain, ``frontier`` cells, ``distance`` by known free cells to the
    nearest of them, ``mates`` heard in this step and ``mates_past``, fading with the steps since then."""
    coarse: int = Field(11, ge=0, le=31)
    """Blocks a side of the coarse map around the UAV, each 3x3 pixels, odd; 0 leaves it out."""
    sides: bool = True
    """The unknown cells below, left of, above and right of the UAV."""
    identity: bool = False
    """Which UAV this is, one of eight, so that linked UAVs with the same map may act apart (Terry et al. 2020)."""
    progress: bool = False
    """Known share of the map, share of the steps flown and steps since the last gain."""
    frames: int = Field(1, ge=1, le=8)
    """Latest scenes shown together, the frame stack of Mnih et al. 2015."""
    visits: bool = True
    """For each move: visits of the next cell since the last gain."""
    gains: bool = True
    """For each move, as planners see it: the view gain there, and distance and discounted gains of what lies ahead."""
    tours: bool = True
    """For each move: the tours that a small beam search finds behind it, in rooms of up to 16x16 cells."""
    tour_width: int = Field(8, ge=1, le=WIDEST)
    """States that this search keeps at each step: the more, the shorter its tours and the slower each decision."""
    prospects: bool = False
    """For each move: how far it is from the best place to look from, on maps of any size, by what is in view there and
    the way to it; once by all that is in view and once with isolated cells counting more."""

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
