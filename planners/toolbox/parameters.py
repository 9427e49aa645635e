"""Parameters of planners: declarations with bounds and ranges, and the shared parameters, each with one unit.

A policy takes the mixins whose parameters it has, and repeats a field where its default is another one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite
from typing import NamedTuple, TypeVar

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.policies.tunable import TUNABLE, declared_in_fields

T = TypeVar("T")


class Bounds(NamedTuple):
    """The numbers that a parameter may have."""

    least: float
    most: float

    def refusal(self, value: object) -> str:
        """Return the expectation that a value fails, for an error message; empty if the value is allowed."""
        if isinstance(value, int | float) and isfinite(value) and self.least <= value <= self.most:
            return ""
        return f"of at least {self.least:g}" + (f" and at most {self.most:g}" if self.most < inf else "")


class Options(tuple[str, ...]):
    """The words that a parameter may have."""

    def refusal(self, value: object) -> str:
        """Return the expectation that a value fails, for an error message; empty if the value is allowed."""
        return "" if value in self else f"to be one of {', '.join(self)}"


#: The ends of a range to tune within, and "log" for a logarithmic scale.
Range = tuple[float, float] | tuple[float, float, str]


def bounded(default: T, least: float, most: float = inf, tunable: Range | None = None) -> T:
    """Declare a parameter: a finite number from ``least`` to ``most``, tuned within the range ``tunable`` if any.

    Where None is the default, it is allowed as well.
    """
    return field(default=default, metadata={"allowed": Bounds(least, most), TUNABLE: tunable})


def one_of(default: T, options: Sequence[str], *, tunable: bool = False) -> T:
    """Declare a parameter: one of the ``options``, among which it is tuned or not."""
    return field(default=default, metadata={"allowed": Options(options), TUNABLE: list(options) if tunable else None})


def declared(kind: type) -> Mapping[str, Bounds | Options]:
    """Return the bounds and options of a class's parameters; a field repeated with a plain default keeps them."""
    return declared_in_fields(kind, "allowed")


class Parameters:
    """Base class of policies that checks the declarations by :func:`bounded` and :func:`one_of`."""

    def __post_init__(self) -> None:
        """Check the parameters.

        Raises:
            InputError: one of them is outside of its bounds, not finite, or none of its options.

        """
        for name, allowed in declared(type(self)).items():
            value = getattr(self, name)
            missing = value is None and getattr(type(self), name) is None
            if not missing and (wanted := allowed.refusal(value)):
                raise InputError(f"{type(self).__name__}: expected {name} {wanted}, got {value!r}")


@dataclass(frozen=True, kw_only=True)
class GainParameters(Parameters):
    """How unknown cells in view are weighed."""

    isolation: float = bounded(8.0, least=0, tunable=(1.0, 64.0, "log"))
    """Additional weight of an unknown cell if all 24 cells around it are known; pockets are finished while near."""
    decay_length: float = bounded(0.5, least=0.01, tunable=(0.1, 2.0, "log"))
    """Distance from the viewpoint over which the weight of an unknown cell falls to 1 / e, in lidar ranges."""


@dataclass(frozen=True, kw_only=True)
class DiscountParameters(Parameters):
    """How gains that take longer to reach are discounted."""

    discount_rate: float = bounded(0.8, least=0, tunable=(0.2, 6.0, "log"))
    """Discount rate of view gains: a gain counts gain * exp(-discount_rate * path_length / lidar_range)."""


@dataclass(frozen=True, kw_only=True)
class ReplanParameters(Parameters):
    """When a UAV chooses again although its goal is still useful."""

    period: float = bounded(0.1, least=0, tunable=(0.05, 1.0, "log"))
    """Steps after which a UAV chooses again if the map has grown, in lidar ranges."""


@dataclass(frozen=True, kw_only=True)
class GoalBonusParameters(Parameters):
    """How a UAV keeps its goal where candidates are compared by values."""

    goal_bonus: float = bounded(0.2, least=0, tunable=(0.0, 1.0))
    """Bonus on the value of a candidate at the UAV's current goal, as a share of the value."""


@dataclass(frozen=True, kw_only=True)
class SwitchCostParameters(Parameters):
    """How a UAV keeps its goal where candidates are compared by lengths of flight."""

    switch_cost: float = bounded(0.2, least=0, tunable=(0.0, 2.0))
    """Cost that another goal than the current one has to save, in lidar ranges."""
