"""What every process does first that flies episodes or holds a policy for the one that started it, its parent."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from multiprocessing.connection import Connection
from typing import Any

from numba.core import event

from indoor_explorers.evaluation.harness.engines.keeper import MOST_PROCESSES, begin_kept
from indoor_explorers.evaluation.harness.episodes.shared_clock import Clock

#: Seconds between two checks that the parent is still running.
CHECK_INTERVAL = 0.5
#: numba has no types for its events.
_Listener: Any = event.Listener
_register: Any = event.register


def begin_serving(clock: Clock, connection: Connection, parent: int, most: int = MOST_PROCESSES) -> None:
    """Prepare this process to serve its parent over a connection, and to end with it.

    Ctrl-C is handled by the command. What policies print goes to the standard error, as the standard output belongs
    to the command. Decisions that the clock times can be interrupted by SIGUSR1, and compiling does not count. A copy
    of this process that a policy makes ends when it leaves the policy's code. ``most``: processes that it may become.
    """
    parent = begin_kept(parent, connection, most)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGUSR1, clock.interrupt)
    clock.process = os.getpid()
    os.dup2(2, 1)
    del sys.argv[1:]  # may name seeds and maps
    threading.Thread(target=_exit_with, args=(parent,), daemon=True).start()
    _register("numba:compile", Compiling(clock))


def _exit_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(CHECK_INTERVAL)
    os._exit(1)


class Compiling(_Listener):  # type: ignore[misc]  # a base class without types
    """Tell the clock when numba compiles for a decision: that does not count."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._depth = 0

    def on_start(self, event: Any) -> None:
        """Begin to count."""
        self._depth += 1
        if self._depth == 1:
            self._clock.begin_compiling()

    def on_end(self, event: Any) -> None:
        """Add what was counted."""
        self._depth -= 1
        if self._depth == 0:
            self._clock.end_compiling()
