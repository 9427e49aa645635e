"""Memory that two processes share: the clock of a policy's decisions, the steps of an episode, and views of UAVs."""

from __future__ import annotations

import mmap
import os
import tempfile
import time
from collections.abc import Sequence
from multiprocessing.reduction import DupFd
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import View
from indoor_explorers.env.grid.arrays import read_only
from indoor_explorers.env.policies.view import LIVE_ARRAYS, Arrays, arrays_of
from indoor_explorers.env.simulation.rollout import Uav
from indoor_explorers.evaluation.harness.episodes.steps import Steps, step_type

#: Places in the first page: when the current decision began, when the one that takes too long began (0 for none), the
#: limit in seconds that it exceeds, the number of decisions that have ended, seconds spent with compiling, and since
#: when it is compiled (0 for not now).
ASKED, OVERDUE, LIMIT, ENDED, COMPILED, COMPILING = range(6)


class DecisionTimeout(BaseException):
    """Interrupts a decision that takes too long; no ``except Exception`` of a policy catches it."""


class Clock:
    """Notes when a call of a policy began; use as a context manager around every such call.

    Times are seconds of :func:`time.monotonic`, which is the same in every process of a machine. A policy's process
    could write anything here: a :class:`~indoor_explorers.evaluation.harness.engines.stopwatch.Stopwatch` checks it.
    """

    def __init__(self, memory: bytearray | mmap.mmap | None = None) -> None:
        self._times = memoryview(bytearray(48) if memory is None else memory)[:48].cast("d")
        self.process: int | None = None
        """The process whose forked copies end with the policy's call; None to end none."""

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


class SharedStepBuffer(SharedClock):
    """Shares a clock, and after it the steps of one episode, between two processes."""

    def begin(self) -> None:
        """Clear the steps of the episode before."""
        os.ftruncate(self._file, mmap.PAGESIZE)

    def add(self, row: np.void) -> None:
        """Append a row of :func:`~.steps.step_type`; the first is the start."""
        os.pwrite(self._file, row.tobytes(), os.fstat(self._file).st_size)

    def steps(self, team: int, base: bool = False) -> Steps:
        """Return the complete steps of an episode of ``team`` UAVs, with a home base or not."""
        kind = step_type(team, base)
        held = os.fstat(self._file).st_size - mmap.PAGESIZE
        return Steps.of(np.frombuffer(os.pread(self._file, held - held % kind.itemsize, mmap.PAGESIZE), kind))


class SharedViews(SharedClock):
    """Shares a clock, and after it the arrays of views, between the process that writes views and one that reads them.

    Both call :meth:`begin` with the same arguments before a batch. Nobody reads what the reader writes there.
    """

    def begin(
        self,
        uavs: Sequence[Uav],
        shape: tuple[int, int],
        *,
        writing: bool = False,
        uncertain: bool = False,
        moves: int = 5,
    ) -> None:
        """Lay out the arrays of some UAVs on (H, W) maps; those of the batch before show other UAVs from now on.

        ``uncertain``: the maps are of log-odds; ``moves`` is that of the maps' levels.
        """
        there = {name: array for name, array in LIVE_ARRAYS.items() if uncertain or not array.uncertain}
        fields = [(name, array.dtype, array.shape_on(shape, moves)) for name, array in there.items()]
        rows = self._rows(len(uavs), np.dtype(fields, align=True), writing=writing)
        shown = np.asarray if writing else read_only
        self.arrays: dict[Uav, Arrays] = {
            uav: tuple(shown(row[name]) if name in there else None for name in LIVE_ARRAYS)
            for uav, row in zip(uavs, rows, strict=True)
        }
        """The arrays of each UAV's latest view; in the reader they are read-only and live."""

    def write(self, uav: Uav, view: View) -> None:
        """Show the arrays of a view to the other process."""
        for shared, array in zip(self.arrays[uav], arrays_of(view), strict=False):
            if shared is not None:
                shared[...] = array

    def _rows(self, count: int, kind: np.dtype[Any], *, writing: bool) -> NDArray[np.void]:
        """Map the memory; it never gets smaller, since a policy may still read the views of an earlier batch."""
        size = count * kind.itemsize
        if os.fstat(self._file).st_size < mmap.PAGESIZE + size:
            os.ftruncate(self._file, mmap.PAGESIZE + size)
        access = mmap.ACCESS_WRITE if writing else mmap.ACCESS_READ
        return np.frombuffer(mmap.mmap(self._file, size, access=access, offset=mmap.PAGESIZE), kind)
