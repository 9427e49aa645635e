"""Parent-side handle of a child process: enforces its limits and reports how it ended."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import time
from collections.abc import Callable
from multiprocessing import Pipe
from typing import Any, NamedTuple

from loky.backend.process import LokyProcess

from indoor_explorers.env.grid.compiled import QUIET
from indoor_explorers.evaluation.harness.engines.channel import Channel
from indoor_explorers.evaluation.harness.engines.keeper import CROWDED, MOST_PROCESSES, MOST_THREADS
from indoor_explorers.evaluation.harness.engines.process_tree import ProcessTree, memory_of, process_of
from indoor_explorers.evaluation.harness.engines.stopwatch import Stopwatch
from indoor_explorers.evaluation.harness.episodes.record import FROM_OUTSIDE, KILLED, STOPPED, TOO_MUCH_MEMORY
from indoor_explorers.evaluation.harness.episodes.shared_memory import SharedClock, overdue_reason
from indoor_explorers.evaluation.harness.experiment.limits import Limits

#: Attempts to start a process.
STARTS = 3
#: Every process uses one thread; the work is parallel over processes.
ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
#: Seconds between two checks of a process.
CHECK_INTERVAL = 0.25
#: Seconds that an interrupted decision has to end before its process is killed.
GRACE = 2.0
#: Seconds that a process, and its keeper, may take to end.
SHUTDOWN_GRACE, KEEPER_GRACE = 5.0, 1.0
#: Seconds that a process may be stopped (SIGSTOP) while this one runs.
MOST_STOPPED = 3.0
#: The most bytes of a message.
LONGEST = 100_000_000
#: The reason of a failure where the process of a policy sent an invalid answer.
UNREADABLE = "the process of the policy sent an answer that cannot be read"


class ProcessExit(NamedTuple):
    """How a process ended."""

    reason: str
    from_outside: bool = False
    """Whether a cause other than the policy may have ended it."""
    fresh: bool = True
    """Whether it had begun no job before the one in which it ended."""


class ProcessHandle:
    """One process that serves this one, and its :mod:`~.keeper`.

    It is a fresh interpreter that never imports the caller's main module.
    """

    def __init__(
        self, limits: Limits, shared: SharedClock, serve: Callable[..., None], *arguments: Any, longest: int = LONGEST
    ) -> None:
        """Start a process that calls ``serve(connection, shared, parent, *arguments)``."""
        self._jobs = 0
        """How many jobs it has begun."""
        self.limits = limits
        self._shared, self._stopwatch = shared, Stopwatch(shared.clock)
        self._checked, self._stopped, self._marked = time.monotonic(), 0.0, False
        connection, theirs = Pipe()
        self._channel = Channel(connection, longest)
        self._process = LokyProcess(
            target=serve, args=(theirs, shared, os.getpid(), *arguments), env=ONE_THREAD | {QUIET: "1"}
        )
        self._process.start()
        theirs.close()
        self._tree, self._server = ProcessTree(self._process.pid), 0
        self._events = select.poll()
        for readable in (self._channel.fileno(), self._process.sentinel):
            self._events.register(readable, select.POLLIN)

    @property
    def ended(self) -> bool:
        """Whether the process has ended."""
        return self._process.exitcode is not None

    def kill(self) -> None:
        """Kill the process and all its descendants."""
        if self._tree.kill() and not self.ended:
            self._signal(signal.SIGCONT)  # to the keeper, which was stopped if the policy found it
            self._exit_code(KEEPER_GRACE)
        if not self.ended:
            self._signal(signal.SIGKILL)
            self._exit_code()

    def close(self) -> None:
        """Kill the process and free the shared memory."""
        self.kill()
        self._channel.close()
        self._shared.close()

    def _await_message(self) -> bytes | ProcessExit:
        """Return its next message, or how it ended before that; enforce the limits meanwhile."""
        while True:
            try:
                message = self._channel.message()
            except ValueError:
                self.kill()
                return ProcessExit(UNREADABLE, fresh=self._jobs <= 1)
            self._events.modify(self._channel.fileno(), self._channel.events)
            wait = 1000 * self._interval if message is None else 0
            ready = [descriptor for descriptor, _ in self._events.poll(wait)]
            due = (not ready and message is None) or time.monotonic() > self._checked + self._interval
            if due and (reason := self._violation()) is not None:
                self.kill()
                return ProcessExit(reason, reason.startswith(STOPPED), self._jobs <= 1)
            if message is not None:
                self._server = self._server or min(self._tree.update(), default=self._process.pid)
                return message
            if self._channel.fileno() not in ready and (ready or self.ended):
                return self._exit()
            try:
                self._channel.transfer()
            except EOFError:
                return self._exit()

    @property
    def _interval(self) -> float:
        """Seconds until the next check."""
        limit = self.limits.decision_timeout
        return CHECK_INTERVAL if limit is None else min(CHECK_INTERVAL, limit / 2)

    @property
    def _counted(self) -> set[int]:
        """The processes whose memory counts."""
        return self._tree.update() or {self._process.pid}

    def _signal(self, number: signal.Signals) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(self._process.pid, number)

    def _exit(self) -> ProcessExit:
        code, fresh = self._exit_code(), self._jobs <= 1
        if code is None:
            self.kill()
            return ProcessExit("the process of the policy closed its connection", fresh=fresh)
        if code == CROWDED:
            most = f"{MOST_PROCESSES} processes or {MOST_THREADS} threads"
            return ProcessExit(f"the process of the policy became more than {most}", fresh=fresh)
        if code >= 0:
            return ProcessExit(f"the process of the policy ended with exit code {code}", fresh=fresh)
        name = signal.Signals(-code).name if -code in set(signal.Signals) else "unknown"
        return ProcessExit(f"{KILLED} {-code} ({name})", -code in FROM_OUTSIDE, fresh)

    def _exit_code(self, grace: float = SHUTDOWN_GRACE) -> int | None:
        """Wait for its end and return its exit code, None if it is still running.

        Polls instead of joining: a policy can close the pipe that joining would wait for.
        """
        until = time.monotonic() + grace
        code: int | None = self._process.exitcode
        while code is None and time.monotonic() < until:
            time.sleep(0.005)
            code = self._process.exitcode
        return code

    def _violation(self) -> str | None:
        """Return which limit the process violates, for which it is killed; None for none.

        The time between two checks counts at most twice the interval, so that the policy is not blamed when the
        machine was asleep or the command was stopped by Ctrl-Z.
        """
        now = time.monotonic()
        passed, self._checked = min(now - self._checked, 2 * self._interval), now
        if memory_of(self._counted, self.limits.memory) > self.limits.memory:
            return f"{TOO_MUCH_MEMORY} {self.limits.memory / 1e9:.3g} GB of memory (--memory-limit)"
        found = process_of(self._server or self._process.pid)
        self._stopped = self._stopped + passed if found and found.state in "Tt" else 0.0
        if self._stopped > MOST_STOPPED:
            return f"{STOPPED} for {MOST_STOPPED:g} s"
        return self._overdue(passed)

    def _overdue(self, passed: float) -> str | None:
        """Interrupt a decision that takes too long; return the reason if that does not end it."""
        limit = self.limits.decision_timeout
        waited, fresh = self._stopwatch.seconds(passed, self._server)
        self._marked = self._marked and not fresh
        if limit is None or waited <= limit:
            return None
        if not self._marked:
            self._marked = True
            self._shared.clock.mark_overdue(self._stopwatch.asked, limit)
            self._signal(signal.SIGUSR1)
        return overdue_reason(limit) if waited > limit + GRACE else None
