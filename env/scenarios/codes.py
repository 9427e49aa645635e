"""Settings of a scenario that compiled code represents by numbers: their names in TOML, and their codes."""

from __future__ import annotations

from enum import IntEnum
from typing import Literal, Self, get_args

RadioModelName = Literal["none", "square", "disc", "line-of-sight", "path-loss", "unlimited", "path-loss-ir2"]
StuckRuleName = Literal["off", "no-discovery", "oscillation"]


class _Code(IntEnum):
    """A setting's code; the name of ``LINE_OF_SIGHT`` in a scenario is ``line-of-sight``."""

    @classmethod
    def named(cls, name: str) -> Self:
        """Return the member of that name in a scenario."""
        return cls[name.upper().replace("-", "_")]


#: Names of the lidar models and the radio models of this package.
LIDAR_MODELS = ("exact", "marsexplorer")
RADIO_MODELS: tuple[str, ...] = get_args(RadioModelName)


class RadioModel(_Code):
    """Which UAVs are in radio contact, see :class:`~indoor_explorers.env.scenarios.scenario.Radio`."""

    NONE = 0
    SQUARE = 1
    DISC = 2
    LINE_OF_SIGHT = 3
    PATH_LOSS = 4
    UNLIMITED = 5
    CUSTOM = 6
    """A plug-in, see :mod:`indoor_explorers.env.simulation.custom_models`."""
    PATH_LOSS_IR2 = 7


class StuckRule(_Code):
    """When an agent without progress is ended, see :class:`~indoor_explorers.env.scenarios.scenario.Stuck`."""

    OFF = 0
    NO_DISCOVERY = 1
    OSCILLATION = 2
