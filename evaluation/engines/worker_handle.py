"""A worker process as its driver sees it: sends jobs, receives records, and enforces limits."""

from __future__ import annotations

import contextlib
import os
import signal
import time
from multiprocessing import Pipe
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any, NamedTuple

from loky.backend.process import LokyProcess

from indoor_explorers.env.grid.compiled import QUIET
from indoor_explorers.evaluation.engines.worker import serve
from indoor_explorers.evaluation.episodes.record import FROM_OUTSIDE, KILLED, TOO_MUCH_MEMORY
from indoor_explorers.evaluation.episodes.shared_clock import overdue_reason
from indoor_explorers.evaluation.episodes.shared_steps import SharedStepBuffer
from indoor_explorers.evaluation.episodes.steps import Steps
from indoor_explorers.evaluation.experiment.limits import Limits

#: Every worker uses one thread; the work is parallel over processes.
ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
#: Seconds between two checks of a worker.
CHECK_INTERVAL = 0.25
#: Seconds that an interrupted decision has to end before its process is killed.
GRACE = 2.0
#: Seconds that a process may take to end after it was told to.
SHUTDOWN_GRACE = 5.0


class WorkerExit(NamedTuple):
    """How a worker ended."""

    reason: str
    from_outside: bool = False
    """Whether something other than the policy may have ended it."""


class WorkerHandle:
    """One worker process: a fresh interpreter that never imports the caller's main module."""

    def __init__(self, limits: Limits) -> None:
        self.fresh = True
        """Whether it has flown nothing yet."""
        self._limits = limits
        self._buffer = SharedStepBuffer()
        self._asked, self._waited, self._checked = 0.0, 0.0, time.monotonic()
        self._marked = False
        self._connection, theirs = Pipe()
        self._process = LokyProcess(
            target=serve, args=(theirs, self._buffer, os.getpid()), env=ONE_THREAD | {QUIET: "1"}
        )
        self._process.start()
        theirs.close()

    def send(self, job: Any) -> None:
        """Send a job, and clear the steps of the one before; a dead worker is ignored here."""
        self.fresh = False
        self._buffer.begin()
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            self._connection.send(job)

    def receive(self) -> Any:
        """Wait for its next message and return it, or its :class:`WorkerExit`; enforce the limits meanwhile."""
        while True:
            ready = wait([self._connection, self._process.sentinel], self._interval)
            if self._connection in ready:
                try:
                    return self._connection.recv()
                except (EOFError, ConnectionResetError):
                    return self._exit()
            if ready or self._process.exitcode is not None:
                return self._exit()
            if (reason := self._violation()) is not None:
                self.kill()
                return WorkerExit(reason)

    def steps(self, team: int) -> Steps:
        """Return the steps of the single episode that it flies or flew last."""
        return self._buffer.steps(team)

    def kill(self) -> None:
        """Kill the process."""
        if self._process.exitcode is None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self._process.pid, signal.SIGKILL)
            self._exit_code()

    def close(self) -> None:
        """Kill the process and free what it shares."""
        self.kill()
        self._connection.close()
        self._buffer.close()

    @property
    def _interval(self) -> float:
        """Seconds until the next check."""
        limit = self._limits.decision_timeout
        return CHECK_INTERVAL if limit is None else min(CHECK_INTERVAL, limit / 2)

    def _exit(self) -> WorkerExit:
        code = self._exit_code()
        if code is None:
            self.kill()
            return WorkerExit("the process of the policy closed its connection")
        if code >= 0:
            return WorkerExit(f"the process of the policy ended with exit code {code}")
        name = signal.Signals(-code).name if -code in set(signal.Signals) else "unknown"
        return WorkerExit(f"{KILLED} {-code} ({name})", -code in FROM_OUTSIDE)

    def _exit_code(self) -> int | None:
        """Wait for its end and return its exit code, None if it is still running.

        Polls instead of joining: a policy can close the pipe that joining would wait for.
        """
        until = time.monotonic() + SHUTDOWN_GRACE
        code: int | None = self._process.exitcode
        while code is None and time.monotonic() < until:
            time.sleep(0.005)
            code = self._process.exitcode
        return code

    def _violation(self) -> str | None:
        """Return which limit it violates, so that it has to be killed; None for none."""
        used = memory_of(self._process.pid)
        if used > self._limits.memory:
            return f"{TOO_MUCH_MEMORY} {self._limits.memory / 1e9:.3g} GB of memory (--memory-limit)"
        limit, waited = self._limits.decision_timeout, self._decision_seconds()
        if limit is None or waited <= limit:
            return None
        if not self._marked:
            self._marked = True
            self._buffer.clock.mark_overdue(self._asked, limit)
            with contextlib.suppress(ProcessLookupError):
                os.kill(self._process.pid, signal.SIGUSR1)
        return overdue_reason(limit) if waited > limit + GRACE else None

    def _decision_seconds(self) -> float:
        """Return how many seconds the current decision has taken so far.

        The time between two checks counts at most twice the interval, so that the policy is not blamed when the
        machine was asleep or the command was stopped by Ctrl-Z.
        """
        now, asked = time.monotonic(), self._buffer.clock.asked
        passed, self._checked = min(now - self._checked, 2 * self._interval), now
        if asked != self._asked or not asked:
            self._asked, self._waited, self._marked = asked, 0.0, False
        else:
            self._waited += passed
        return self._waited


def ask_once(question: Any, limits: Limits) -> Any:
    """Return the answer of a worker process of its own to one question, or how that process ended."""
    worker = WorkerHandle(limits)
    try:
        if (ended := worker.receive()) is not None:
            return ended
        worker.send(question)
        return worker.receive()
    finally:
        worker.close()


def memory_of(process: int | None) -> int:
    """Return the bytes of memory that a process uses, 0 where the system does not say."""
    try:
        resident = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    except (OSError, IndexError):
        return 0
    return resident * os.sysconf("SC_PAGE_SIZE")
