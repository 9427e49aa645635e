"""Marks of single parameters of tests."""

from collections.abc import Sequence
from itertools import product
from typing import Any

import pytest


def slow(*values: Any) -> list[Any]:
    """Return parameters, of one argument each, that `make test` leaves to `make test-all`."""
    return [pytest.param(value, marks=pytest.mark.slow) for value in values]


def spread(*axes: Sequence[Any]) -> list[Any]:
    """Return all combinations of the values of some arguments; `make test` leaves most of them to `make test-all`.

    Those that it runs have every value of every argument, as the entries of a Latin square do.
    """
    every = sorted(map(len, axes))[-2]
    return [
        pytest.param(*values, marks=[pytest.mark.slow] * (sum(place) % every > 0))
        for place, values in zip(product(*map(range, map(len, axes))), product(*axes), strict=True)
    ]
