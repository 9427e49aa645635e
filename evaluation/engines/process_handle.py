"""A process that serves this one, as this one sees it: its limits are enforced and its end is told."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import time
from collections.abc import Callable
from multiprocessing import Pipe
from pathlib import Path
from typing import Any, NamedTuple

from loky.backend.process import LokyProcess

from indoor_explorers.env.grid.compiled import QUIET
from indoor_explorers.evaluation.episodes.record import FROM_OUTSIDE, KILLED, TOO_MUCH_MEMORY
from indoor_explorers.evaluation.episodes.shared_clock import SharedClock, overdue_reason
from indoor_explorers.evaluation.experiment.limits import Limits

#: Attempts to start a process.
STARTS = 3
#: Every process uses one thread; the work is parallel over processes.
ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
#: Seconds between two checks of a process.
CHECK_INTERVAL = 0.25
#: Seconds that an interrupted decision has to end before its process is killed.
GRACE = 2.0
#: Seconds that a process may take to end after it was told to.
SHUTDOWN_GRACE = 5.0


class ProcessExit(NamedTuple):
    """How a process ended."""

    reason: str
    from_outside: bool = False
    """Whether something other than the policy may have ended it."""
    fresh: bool = True
    """Whether it had begun no job before the one in which it ended."""


class ProcessHandle:
    """One process that serves this one: a fresh interpreter that never imports the caller's main module."""

    def __init__(self, limits: Limits, shared: SharedClock, serve: Callable[..., None], *arguments: Any) -> None:
        """Start a process that calls ``serve(connection, shared, parent, *arguments)``."""
        self._jobs = 0
        """How many jobs it has begun."""
        self.limits = limits
        self._shared = shared
        self._asked, self._waited, self._checked = 0.0, 0.0, time.monotonic()
        self._marked = False
        self._connection, theirs = Pipe()
        self._process = LokyProcess(
            target=serve, args=(theirs, shared, os.getpid(), *arguments), env=ONE_THREAD | {QUIET: "1"}
        )
        self._process.start()
        theirs.close()
        self._events = select.poll()
        for readable in (self._connection.fileno(), self._process.sentinel):
            self._events.register(readable, select.POLLIN)

    @property
    def ended(self) -> bool:
        """Whether the process has ended."""
        return self._process.exitcode is not None

    def kill(self) -> None:
        """Kill the process."""
        if not self.ended:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self._process.pid, signal.SIGKILL)
            self._exit_code()

    def close(self) -> None:
        """Kill the process and free what it shares."""
        self.kill()
        self._connection.close()
        self._shared.close()

    def _await_message(self) -> ProcessExit | None:
        """Wait for its next message, or return how it ended before that; enforce the limits meanwhile."""
        while True:
            ready = [descriptor for descriptor, _ in self._events.poll(1000 * self._interval)]
            due = not ready or time.monotonic() > self._checked + self._interval
            if due and (reason := self._violation()) is not None:
                self.kill()
                return ProcessExit(reason, fresh=self._jobs <= 1)
            if self._connection.fileno() in ready:
                return None
            if ready or self.ended:
                return self._exit()

    @property
    def _interval(self) -> float:
        """Seconds until the next check."""
        limit = self.limits.decision_timeout
        return CHECK_INTERVAL if limit is None else min(CHECK_INTERVAL, limit / 2)

    def _exit(self) -> ProcessExit:
        code, fresh = self._exit_code(), self._jobs <= 1
        if code is None:
            self.kill()
            return ProcessExit("the process of the policy closed its connection", fresh=fresh)
        if code >= 0:
            return ProcessExit(f"the process of the policy ended with exit code {code}", fresh=fresh)
        name = signal.Signals(-code).name if -code in set(signal.Signals) else "unknown"
        return ProcessExit(f"{KILLED} {-code} ({name})", -code in FROM_OUTSIDE, fresh)

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
        if used > self.limits.memory:
            return f"{TOO_MUCH_MEMORY} {self.limits.memory / 1e9:.3g} GB of memory (--memory-limit)"
        limit, waited = self.limits.decision_timeout, self._decision_seconds()
        if limit is None or waited <= limit:
            return None
        if not self._marked:
            self._marked = True
            self._shared.clock.mark_overdue(self._asked, limit)
            with contextlib.suppress(ProcessLookupError):
                os.kill(self._process.pid, signal.SIGUSR1)
        return overdue_reason(limit) if waited > limit + GRACE else None

    def _decision_seconds(self) -> float:
        """Return how many seconds the current decision has taken so far.

        The time between two checks counts at most twice the interval, so that the policy is not blamed when the
        machine was asleep or the command was stopped by Ctrl-Z.
        """
        now, asked = time.monotonic(), self._shared.clock.asked
        passed, self._checked = min(now - self._checked, 2 * self._interval), now
        if asked != self._asked or not asked:
            self._asked, self._waited, self._marked = asked, 0.0, False
        else:
            self._waited += passed
        return self._waited


def memory_of(process: int | None) -> int:
    """Return the bytes of memory that a process uses, 0 where the system does not say."""
    try:
        resident = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    except (OSError, IndexError):
        return 0
    return resident * os.sysconf("SC_PAGE_SIZE")
