"""The clock of a policy's decisions, in memory that its process shares with the one that enforces the time limit."""

from __future__ import annotations

import mmap
import os
import tempfile
import time
from multiprocessing.reduction import DupFd
from typing import Any, Self

#: Places in the first page: when the current decision began, when the one that takes too long began (0 for none), and
#: the limit in seconds that it exceeds.
ASKED, OVERDUE, LIMIT = 0, 1, 2


class DecisionTimeout(BaseException):
    """Interrupts a decision that takes too long; no ``except Exception`` of a policy catches it."""


class Clock:
    """Notes when a call of a policy began; use as a context manager around every such call.

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
        """When the current decision began, 0 while there is none."""
        return self._times[ASKED]

    def mark_overdue(self, asked: float, limit: float) -> None:
        """Note that the decision that began at ``asked`` takes longer than ``limit`` seconds."""
        self._times[LIMIT] = limit
        self._times[OVERDUE] = asked

    def interrupt(self, *signal: object) -> None:
        """Raise, once, if the current decision is marked as overdue; can be used as a signal handler.

        Raises:
            DecisionTimeout: it is.

        """
        if self.asked and self._times[OVERDUE] == self.asked:
            self._times[OVERDUE] = 0.0
            raise DecisionTimeout(overdue_reason(self._times[LIMIT]))


def overdue_reason(limit: float) -> str:
    """Return the reason of an episode that failed because a decision exceeded ``limit`` seconds."""
    return f"decision took longer than {limit:g} s (--decision-timeout)"


class SharedClock:
    """Shares a clock between two processes, in the first page of a file without a name.

    What follows that page is for subclasses. Pickled only to start the second process.
    """

    def __init__(self, inherited: Any = None) -> None:
        self._file = _anonymous_file() if inherited is None else inherited.detach()
        if inherited is None:
            os.ftruncate(self._file, mmap.PAGESIZE)
        self._page = mmap.mmap(self._file, mmap.PAGESIZE)
        self.clock = Clock(self._page)

    def __reduce__(self) -> tuple[type[Self], tuple[Any]]:
        return type(self), (DupFd(self._file),)

    def close(self) -> None:
        """Close the file; the clock does not change any more."""
        os.close(self._file)


def _anonymous_file() -> int:
    """Open a file without a name: in memory where the system can, so that a full disk does not matter."""
    if hasattr(os, "memfd_create"):
        return os.memfd_create("shared")
    with tempfile.TemporaryFile() as file:
        return os.dup(file.fileno())
