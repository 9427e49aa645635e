"""Fixtures of the learners' tests."""

from tests.learners.rooms import untrained

__all__ = ["untrained"]
