"""Keeps the time in which numba compiles, or loads compiled code, out of decision times.

Compiling happens once on a machine and loading once in a process; neither belongs to the cost of a decision. Both count
where numba's events are not what :mod:`indoor_explorers.env.grid.numba_parts` expects.
"""

from __future__ import annotations

import time
from functools import cache
from typing import Any

from indoor_explorers.env.grid.numba_parts import events
from indoor_explorers.evaluation.harness.episodes.shared_memory import Clock

_Listener: Any = events.Listener if events else object


def thinking_time() -> float:
    """Return the seconds of a clock that is stopped while numba compiles or loads compiled code."""
    timer = _compiler_timer()
    return time.perf_counter() - (timer.duration if timer is not None and timer.done else 0.0)


@cache
def _compiler_timer() -> Any:
    """Return a timer of the seconds, from now on, that numba's compiler is busy in this process; None without one."""
    if events is None:
        return None
    timer = events.TimingListener()
    events.register("numba:compiler_lock", timer)
    return timer


def note_compiling(clock: Clock) -> None:
    """Have a clock of decisions note when numba compiles in this process: that does not count for their time limit."""
    if events is not None:
        events.register("numba:compile", Compiling(clock))


class Compiling(_Listener):  # type: ignore[misc]  # a base class without types
    """Notes in a clock when numba compiles; nested compilations count once."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._depth = 0

    def on_start(self, event: Any) -> None:
        """Begin to count."""
        self._depth += 1
        if self._depth == 1:
            self._clock.begin_compiling()

    def on_end(self, event: Any) -> None:
        """Add the time since the beginning."""
        self._depth -= 1
        if self._depth == 0:
            self._clock.end_compiling()
