"""The options beside places, what a network sees of them, and what rules think of them."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.learners.reports.situation import NUMBERS


class Option(IntEnum):
    """What a UAV can do in place of flying to a place."""

    REPORT = 0
    """Fly to the home base and report, or let a teammate in contact that is nearer do so."""
    RELAY = 1
    """Stay where the base is in contact, so that teammates farther away reach it."""
    CLOSE = 2
    """Fly to where closing a loop of the own path corrects the pose."""


#: Numbers about the options: the situation of a report, and what a loop closure costs and corrects.
CLOSURE = 5
OPTION_COMMON = NUMBERS + CLOSURE


class Options(NamedTuple):
    """The options at a choice."""

    numbers: NDArray[np.float32]
    """(OPTION_COMMON,) inputs of the network."""
    rules: NDArray[np.float32]
    """(O,) value of each option to a rule, beyond that of the planner's best place; -inf where there is none."""


def no_options() -> Options:
    """Return that there are no options."""
    return Options(np.zeros(OPTION_COMMON, np.float32), np.full(len(Option), -np.inf, np.float32))
