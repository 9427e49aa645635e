"""Checks of planners' parameters when a policy is made, so that no episode fails because of them."""

from __future__ import annotations

from math import isfinite

from indoor_explorers.env.errors import InputError


def at_least(parameters: object, least: float, *names: str) -> None:
    """Require finite fields of a parameter object to be ``least`` or more.

    Raises:
        InputError: one of them is less, or not finite.

    """
    for name in names:
        value = getattr(parameters, name)
        if not isinstance(value, int | float) or not isfinite(value) or value < least:
            raise InputError(f"{type(parameters).__name__}: expected {name} of at least {least:g}, got {value!r}")
