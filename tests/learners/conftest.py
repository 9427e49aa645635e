"""Fixtures of the learners' tests."""

import pytest

from tests.learners.dddqn.rooms import untrained

__all__ = ["untrained"]


@pytest.fixture(autouse=True)
def _always_one_thread(one_thread: None) -> None:
    """Run torch on one thread in all tests of the learners."""
