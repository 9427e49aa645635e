"""Memory that a worker shares with its driver: since when it decides, and the steps of its episode, if it dies.

The first page is a clock of the decision that is going on. The rows behind it are the steps of an episode that is
flown alone.
"""

from __future__ import annotations

import mmap
import os
import tempfile
import time
from collections.abc import Callable
from multiprocessing.reduction import DupFd
from typing import Any

import numpy as np

from indoor_explorers.evaluation.episodes.steps import Steps, step_type

#: Numbers of the first page: when the decision going on was asked for, the one that takes too long (0 is none), and
#: the limit in seconds that it broke.
ASKED, OVERDUE, LIMIT = 0, 1, 2


class DecisionTimeout(BaseException):
    """Interrupt a decision that takes too long; no ``except Exception`` of a policy catches it."""


class Clock:
    """Say since when a policy has been asked for something; use as a context manager around whatever is the policy's.

    Times are seconds of :func:`time.monotonic`, which is the same in every process of a machine.
    """

    def __init__(self, memory: bytearray | mmap.mmap | None = None) -> None:
        self._times = memoryview(bytearray(24) if memory is None else memory)[:24].cast("d")

    def __enter__(self) -> None:
        self._times[ASKED] = time.monotonic()

    def __exit__(self, *error: object) -> None:
        self._times[ASKED] = 0.0

    @property
    def asked(self) -> float:
        """When the decision that is going on began, 0 while there is none."""
        return self._times[ASKED]

    def mark_overdue(self, asked: float, limit: float) -> None:
        """Say that the decision that began at ``asked`` takes longer than ``limit`` seconds."""
        self._times[LIMIT] = limit
        self._times[OVERDUE] = asked

    def interrupt(self, *signal: object) -> None:
        """Raise, once, if the decision that is going on takes too long; fits as a signal's handler.

        Raises:
            DecisionTimeout: it does.

        """
        if self.asked and self._times[OVERDUE] == self.asked:
            self._times[OVERDUE] = 0.0
            raise DecisionTimeout(overdue_reason(self._times[LIMIT]))


def overdue_reason(limit: float) -> str:
    """Return why an episode failed whose policy took longer than ``limit`` seconds."""
    return f"decision took longer than {limit:g} s (--decision-timeout)"


class SharedStepBuffer:
    """Share a clock and the steps of one episode between two processes; pickled only while one of them starts."""

    def __init__(self, inherited: Any = None) -> None:
        self._file = _anonymous_file() if inherited is None else inherited.detach()
        if inherited is None:
            os.ftruncate(self._file, mmap.PAGESIZE)
        self._page = mmap.mmap(self._file, mmap.PAGESIZE)
        self.clock = Clock(self._page)

    def __reduce__(self) -> tuple[Callable[..., SharedStepBuffer], tuple[Any]]:
        return SharedStepBuffer, (DupFd(self._file),)

    def close(self) -> None:
        """Let go of the file; the clock stands still from now on."""
        os.close(self._file)

    def begin(self) -> None:
        """Forget the steps of the episode before."""
        os.ftruncate(self._file, mmap.PAGESIZE)

    def add(self, row: np.void) -> None:
        """Append a row of :func:`~indoor_explorers.evaluation.episodes.steps.step_type`; the first is the start."""
        os.pwrite(self._file, row.tobytes(), os.fstat(self._file).st_size)

    def steps(self, team: int) -> Steps:
        """Return the whole steps of an episode of ``team`` UAVs."""
        kind = step_type(team)
        held = os.fstat(self._file).st_size - mmap.PAGESIZE
        return Steps.of(np.frombuffer(os.pread(self._file, held - held % kind.itemsize, mmap.PAGESIZE), kind))


def _anonymous_file() -> int:
    """Open a file without a name: in memory where the system can, so that a full disk does not matter."""
    if hasattr(os, "memfd_create"):
        return os.memfd_create("steps")
    with tempfile.TemporaryFile() as file:
        return os.dup(file.fileno())
