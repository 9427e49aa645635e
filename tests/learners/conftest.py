"""Fixtures of the learners' tests."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import torch

from tests.learners.dddqn.rooms import untrained

__all__ = ["one_thread", "untrained"]


@pytest.fixture(autouse=True)
def one_thread() -> Iterator[None]:
    """Run torch on one thread: small matrices are slower on many, above all beside other processes."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)
