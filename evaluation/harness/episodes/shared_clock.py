"""The clock of a policy's decisions, in memory that its process shares with the one that enforces the time limit."""

from __future__ import annotations

import mmap
import os
import tempfile
import time
from multiprocessing.reduction import DupFd
from typing import Any, Self

#: Places in the first page: when the current decision began, when the one that takes too long began (0 for none), the
#: limit in seconds that it exceeds, the number of decisions that have ended, seconds spent with compiling, and since
#: when it is compiled (0 for not now).
ASKED, OVERDUE, LIMIT, ENDED, COMPILED, COMPILING = range(6)


class DecisionTimeout(BaseException):
    """Interrupts a decision that takes too long; no ``except Exception`` of a policy catches it."""


class Clock:
    """Notes when a call of a policy began; use as a context manager around every such call.

    Times are seconds of :func:`time.monotonic`, which is the same in every process of a machine. What a policy's
    process notes there is believed only as far as a
    :class:`~indoor_explorers.evaluation.harness.engines.stopwatch.Stopwatch` finds it possible.
    """

    def __init__(self, memory: bytearray | mmap.mmap | None = None) -> None:
        self._times = memoryview(bytearray(48) if memory is None else memory)[:48].cast("d")
        self.process: int | None = None
        """The process whose copies, made by a policy that forked it, end with the policy's call; None for no such."""

    def __enter__(self) -> None:
        self._times[ASKED] = time.monotonic()

    def __exit__(self, *error: object) -> None:
        if self.process is not None and os.getpid() != self.process:
            os._exit(1)
        self._times[ASKED] = 0.0
        self._times[ENDED] += 1.0

    @property
    def asked(self) -> float:
        """When the current decision began, 0 while there is none."""
        return self._times[ASKED]

    @property
    def ended(self) -> float:
        """How many decisions have ended."""
        return self._times[ENDED]

    @property
    def compiled(self) -> float:
        """Seconds spent with compiling so far."""
        since = self._times[COMPILING]
        return self._times[COMPILED] + (time.monotonic() - since if since else 0.0)

    def begin_compiling(self) -> None:
        """Note that something is compiled from now on."""
        self._times[COMPILING] = time.monotonic()

    def end_compiling(self) -> None:
        """Note that this has ended."""
        self._times[COMPILED], self._times[COMPILING] = self.compiled, 0.0

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
