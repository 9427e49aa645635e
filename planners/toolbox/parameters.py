"""Parameters that planners share, one word with one unit each, and checks of them when a policy is made.

A policy takes the mixins whose parameters it has, and repeats a field where its default is another one.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from indoor_explorers.env.errors import InputError


@dataclass(frozen=True, kw_only=True)
class GainParameters:
    """How unknown cells in view are weighed."""

    isolation: float = 8.0
    """Additional weight of an unknown cell if all 24 cells around it are known; pockets are finished while near."""
    decay_length: float = 0.5
    """Distance from the place that looks over which the weight of an unknown cell falls to 1 / e, in lidar ranges."""


@dataclass(frozen=True, kw_only=True)
class DiscountParameters:
    """How gains that take longer to reach are discounted."""

    discount_rate: float = 0.8
    """Discount rate of view gains: a gain counts gain * exp(-discount_rate * path_length / lidar_range)."""


@dataclass(frozen=True, kw_only=True)
class ReplanParameters:
    """When a UAV chooses again although its goal is still useful."""

    period: float = 0.1
    """Steps after which a UAV chooses again if the map has grown, in lidar ranges."""


@dataclass(frozen=True, kw_only=True)
class GoalBonusParameters:
    """How a UAV keeps its goal where places are compared by values."""

    goal_bonus: float = 0.2
    """Bonus on the value of a place at the UAV's current goal, as a share of the value."""


@dataclass(frozen=True, kw_only=True)
class SwitchCostParameters:
    """How a UAV keeps its goal where places are compared by lengths of flight."""

    switch_cost: float = 0.2
    """Cost that another goal than the current one has to save, in lidar ranges."""


def at_least(parameters: object, least: float, *names: str) -> None:
    """Require finite fields of a parameter object to be ``least`` or more.

    Raises:
        InputError: one of them is less, or not finite.

    """
    for name in names:
        value = getattr(parameters, name)
        if not isinstance(value, int | float) or not isfinite(value) or value < least:
            raise InputError(f"{type(parameters).__name__}: expected {name} of at least {least:g}, got {value!r}")
