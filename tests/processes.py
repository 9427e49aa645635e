"""Processes that tests start, watch and wait for."""

import time
from collections.abc import Callable

from indoor_explorers.evaluation.harness.engines.process_tree import process_of


def runs(pid: int) -> bool:
    """Tell whether a process runs; one that has ended but was not waited for does not."""
    return process_of(pid) is not None


def wait_until(condition: Callable[[], object], seconds: float = 30.0) -> None:
    """Wait until a condition holds; fail after some seconds."""
    until = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.02)
