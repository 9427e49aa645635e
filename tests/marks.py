"""Marks of single parameters of tests."""

from typing import Any

import pytest


def slow(*values: Any) -> list[Any]:
    """Return parameters, of one argument each, that `make test` leaves to `make test-all`."""
    return [pytest.param(value, marks=pytest.mark.slow) for value in values]
