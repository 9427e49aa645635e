"""A worker process as its driver sees it: it is sent jobs, and watched."""

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
from indoor_explorers.evaluation.episodes.shared_steps import SharedStepBuffer, overdue_reason
from indoor_explorers.evaluation.episodes.steps import Steps
from indoor_explorers.evaluation.experiment.limits import Limits

#: Every worker keeps to one thread: the processes are the parallelism.
ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
#: Seconds between two looks at a worker.
LOOK_EVERY = 0.25
#: Seconds that an interrupted decision has to end before its process is killed.
GRACE = 2.0
#: Signals that may come from elsewhere, such as from the system when it is short of memory.
FROM_OUTSIDE = (signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT)
#: Seconds that a process may take to end after it was told to.
SHUTDOWN_GRACE = 5.0


class WorkerExit(NamedTuple):
    """How a worker ended."""

    reason: str
    from_outside: bool = False
    """Whether somebody else than the policy may have ended it."""


class WorkerHandle:
    """One worker process: a fresh interpreter that never imports the caller's main module."""

    def __init__(self, limits: Limits) -> None:
        self.fresh = True
        """Whether it has flown nothing yet."""
        self._limits = limits
        self._buffer = SharedStepBuffer()
        self._asked, self._waited, self._looked = 0.0, 0.0, time.monotonic()
        self._marked = False
        self._connection, theirs = Pipe()
        self._process = LokyProcess(
            target=serve, args=(theirs, self._buffer, os.getpid()), env=ONE_THREAD | {QUIET: "1"}
        )
        self._process.start()
        theirs.close()

    def send(self, job: Any) -> None:
        """Send a job; a worker that is dead already does not mind. The steps of the one before are forgotten."""
        self.fresh = False
        self._buffer.begin()
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            self._connection.send(job)

    def hear(self) -> Any:
        """Wait for its next message and return it, or its :class:`WorkerExit`; watches it meanwhile."""
        while True:
            ready = wait([self._connection, self._process.sentinel], self._patience)
            if self._connection in ready:
                try:
                    return self._connection.recv()
                except (EOFError, ConnectionResetError):
                    return self._exit()
            if ready or self._process.exitcode is not None:
                return self._exit()
            if (reason := self._look()) is not None:
                self.kill()
                return WorkerExit(reason)

    def steps(self, team: int) -> Steps:
        """Return the steps of the episode that it flies, or flew last, alone."""
        return self._buffer.steps(team)

    def kill(self) -> None:
        """End it at once."""
        if self._process.exitcode is None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self._process.pid, signal.SIGKILL)
            self._exit_code()

    def close(self) -> None:
        """End it and let go of all that it shares."""
        self.kill()
        self._connection.close()
        self._buffer.close()

    @property
    def _patience(self) -> float:
        """Seconds until the next look."""
        limit = self._limits.decision_timeout
        return LOOK_EVERY if limit is None else min(LOOK_EVERY, limit / 2)

    def _exit(self) -> WorkerExit:
        code = self._exit_code()
        if code is None:
            self.kill()
            return WorkerExit("the process of the policy closed its connection")
        if code >= 0:
            return WorkerExit(f"the process of the policy ended with exit code {code}")
        name = signal.Signals(-code).name if -code in set(signal.Signals) else "unknown"
        return WorkerExit(f"the process of the policy was killed by signal {-code} ({name})", -code in FROM_OUTSIDE)

    def _exit_code(self) -> int | None:
        """Wait for its end and return how it ended, None when it goes on.

        Looks instead of joining: a policy can close the pipe that joining would wait for.
        """
        until = time.monotonic() + SHUTDOWN_GRACE
        code: int | None = self._process.exitcode
        while code is None and time.monotonic() < until:
            time.sleep(0.005)
            code = self._process.exitcode
        return code

    def _look(self) -> str | None:
        """Return why it has to be killed now, None while it behaves."""
        used = memory_of(self._process.pid)
        if used > self._limits.memory:
            return f"worker used more than {self._limits.memory / 1e9:.3g} GB of memory (--memory-limit)"
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
        """Return how long the decision going on has been seen to go on.

        The time between two looks counts at most twice what it should be, so that a machine that was asleep, or a job
        that was stopped by Ctrl-Z, puts no blame on the policy.
        """
        now, asked = time.monotonic(), self._buffer.clock.asked
        passed, self._looked = min(now - self._looked, 2 * self._patience), now
        if asked != self._asked or not asked:
            self._asked, self._waited, self._marked = asked, 0.0, False
        else:
            self._waited += passed
        return self._waited


def memory_of(process: int | None) -> int:
    """Return the bytes of memory that a process uses, 0 where the system does not tell."""
    try:
        resident = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    except (OSError, IndexError):
        return 0
    return resident * os.sysconf("SC_PAGE_SIZE")
