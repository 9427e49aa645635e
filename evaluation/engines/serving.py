"""What every process does first that flies episodes or holds a policy for the one that started it, its parent."""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import sys
import threading
import time
from typing import Any

from numba.core import event

from indoor_explorers.evaluation.episodes.shared_clock import Clock

#: Seconds between two checks that the parent is still running.
CHECK_INTERVAL = 0.5
#: Asks Linux for a signal when the thread that started this process ends.
_PR_SET_PDEATHSIG = 1
#: numba has no types for its events.
_Listener: Any = event.Listener
_register: Any = event.register


def begin_serving(clock: Clock, parent: int) -> None:
    """Prepare this process to serve its parent, and exit when the parent is killed.

    Ctrl-C is handled by the command. What policies print goes to the standard error, as the standard output belongs
    to the command. Decisions that the clock times can be interrupted by SIGUSR1, and compiling does not count.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGUSR1, clock.interrupt)
    os.dup2(2, 1)
    del sys.argv[1:]  # may name seeds and maps
    threading.Thread(target=_exit_with, args=(parent,), daemon=True).start()
    _register("numba:compile", Compiling(clock))


def die_with_parent_thread() -> None:
    """Have Linux kill this process with the thread that started it, whatever code of a policy is running then."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError, AttributeError):
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, int(signal.SIGKILL))


def _exit_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(CHECK_INTERVAL)
    os._exit(1)


class Compiling(_Listener):  # type: ignore[misc]  # a base class without types
    """Restart the clock of a decision after each function that numba compiled for it: compiling does not count."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._depth = 0
        self._deciding = False

    def on_start(self, event: Any) -> None:
        """Stop the clock."""
        self._depth += 1
        if self._depth == 1:
            self._deciding = self._clock.asked > 0
            self._clock.__exit__()

    def on_end(self, event: Any) -> None:
        """Start it again."""
        self._depth -= 1
        if self._depth == 0 and self._deciding:
            self._clock.__enter__()
