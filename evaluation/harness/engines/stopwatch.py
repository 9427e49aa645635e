"""Measures the current decision of another process, without trusting the times that this process notes."""

from __future__ import annotations

import time

from indoor_explorers.evaluation.harness.engines.process_tree import busy_time
from indoor_explorers.evaluation.harness.episodes.shared_memory import Clock

#: Seconds of compiling that do not count, over the life of a process.
MOST_COMPILING = 900.0


class Stopwatch:
    """Measures decisions of a process, from the question to the answer where the process is not trusted.

    A process notes in its clock when decisions begin and end and when it compiles. One that holds a policy could write
    anything there. So the time restarts only when more decisions have ended, at most as many as were asked for; and
    after compiling only if its threads were busy then, for at most :data:`MOST_COMPILING` in all.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self.asked = 0.0
        """When the current decision began, by the clock of the process."""
        self._began, self._waited, self._left = 0.0, 0.0, MOST_COMPILING
        self._due: float | None = None
        """Decisions that are still outstanding; None where the process is trusted."""
        self._ended, self._compiled = 0.0, 0.0
        self._busy: float | None = None

    def ask(self, decisions: int) -> None:
        """Restart, as the process is asked for this many decisions; it is not trusted from now on."""
        self._due, self._ended, self._compiled = decisions, self._clock.ended, self._clock.compiled
        self._began, self._waited = time.monotonic(), 0.0

    def seconds(self, passed: float, pid: int) -> tuple[float, bool]:
        """Return how many seconds the decision took so far, and whether it is a new one.

        Args:
            passed: seconds since this was called last.
            pid: the process.

        """
        busy, passed = busy_time(pid), min(passed, time.monotonic() - self._began)
        if fresh := self._progress():
            self._waited = 0.0
        elif (compiled := self._compiling(passed, busy)) > passed / 2 and self._waited + compiled <= self._left:
            self._left -= self._waited + compiled
            self._waited = passed - compiled
        else:
            self._waited += passed
        self.asked, self._compiled, self._busy = self._clock.asked, self._clock.compiled, busy
        return self._waited, fresh

    def _progress(self) -> bool:
        if self._due is None:
            return self._clock.asked == 0.0 or self._clock.asked != self.asked
        more = self._clock.ended - self._ended
        if fresh := 0.0 < more <= self._due:
            self._ended, self._due = self._ended + more, self._due - more
        return fresh

    def _compiling(self, passed: float, busy: float | None) -> float:
        """Return how much of the time that passed was spent with compiling."""
        most = passed if busy is None or self._busy is None else min(passed, busy - self._busy)
        return max(0.0, min(self._clock.compiled - self._compiled, most))
