"""The ranges within which parameters of policies are tuned, which their fields declare as metadata.

``field(default=0.1, metadata={"tunable": (0.01, 1.0, "log")})`` declares a range, here on a logarithmic scale, and
``{"tunable": ["size", "gain"]}`` choices. A parameter whose default is an int takes whole numbers.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any, NamedTuple

from indoor_explorers.env.errors import InputError, one_line

#: The key in the metadata of a field.
TUNABLE = "tunable"
#: The third entry of a range on a logarithmic scale.
LOG = "log"


class Span(NamedTuple):
    """A range of numbers, both ends included; ``log`` is a logarithmic scale, ``whole`` whole numbers alone."""

    low: float
    high: float
    log: bool = False
    whole: bool = False

    def __str__(self) -> str:
        return f"{self.low:g} to {self.high:g}" + (" (log)" if self.log else "")

    def __contains__(self, value: object) -> bool:
        if isinstance(value, bool) or not isinstance(value, int | float):
            return False
        return self.low <= value <= self.high and (not self.whole or value == int(value))


class Choices(tuple[Any, ...]):
    """Words or numbers to choose among."""

    def __str__(self) -> str:
        return " or ".join(map(str, self))


Tunable = Span | Choices


def declared_in_fields(kind: type, key: str) -> dict[str, Any]:
    """Return a key of the metadata of a class's fields by field; one repeated with a plain default keeps it."""
    fields = [each for base in reversed(kind.__mro__) for each in vars(base).get("__dataclass_fields__", {}).values()]
    return {each.name: each.metadata[key] for each in fields if key in each.metadata}


def tunable_parameters(kind: Any) -> dict[str, Tunable]:
    """Return the ranges that the fields of a policy's class declare, in the order of its constructor.

    Raises:
        InputError: a declaration is neither a range nor a list of choices.

    """
    if not (isinstance(kind, type) and dataclasses.is_dataclass(kind)):
        return {}
    declared = declared_in_fields(kind, TUNABLE)
    fields = {each.name: each.default for each in dataclasses.fields(kind) if declared.get(each.name) is not None}
    return {name: read_tunable(declared[name], default, name) for name, default in fields.items()}


def read_tunable(declared: object, default: object, name: str) -> Tunable:
    """Return the range or the choices of a parameter; see the module.

    Raises:
        InputError: they are neither.

    """
    if isinstance(declared, list) and len(declared) > 1 and len(set(map(repr, declared))) == len(declared):
        return Choices(declared)
    if isinstance(declared, tuple) and (span := _span(declared, isinstance(default, int))) is not None:
        return span
    raise InputError(
        f"parameter {name!r}: expected a range (low, high) with low < high, (low, high, 'log') with 0 < low < high, or "
        f"a list of different choices, whole numbers where the default is one, got {one_line(repr(declared))}"
    )


def _span(declared: Sequence[Any], whole: bool) -> Span | None:
    """Return the range that a tuple declares, None if it declares none."""
    ends, scale = declared[:2], list(declared[2:])
    numbers = all(isinstance(each, int if whole else int | float) and isfinite(each) for each in ends)
    if len(ends) < 2 or not numbers or scale not in ([], [LOG]) or not ends[0] < ends[1] or (scale and ends[0] <= 0):
        return None
    return Span(ends[0], ends[1], bool(scale), whole)


def told(ranges: Mapping[str, Tunable]) -> str:
    """Return parameters and their ranges in a line."""
    return ", ".join(f"{name} {each}" for name, each in ranges.items())
