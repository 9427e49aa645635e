"""The start of every worker process and policy process: it serves its parent, and ends with it."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from multiprocessing.connection import Connection

from indoor_explorers.evaluation.harness.engines.keeper import MOST_PROCESSES, begin_kept
from indoor_explorers.evaluation.harness.episodes.shared_memory import Clock
from indoor_explorers.evaluation.harness.episodes.thinking_time import note_compiling

#: Seconds between two checks that the parent is still running.
CHECK_INTERVAL = 0.5


def begin_serving(clock: Clock, connection: Connection, parent: int, most: int = MOST_PROCESSES) -> None:
    """Prepare this process to serve its parent over a connection, and to end with it.

    Ctrl-C is handled by the command. What policies print goes to the standard error, as the standard output belongs
    to the command. Decisions that the clock times can be interrupted by SIGUSR1, and compiling does not count. A copy
    of this process that a policy makes ends when it leaves the policy's code. ``most`` limits the number of processes.
    """
    parent = begin_kept(parent, connection, most)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGUSR1, clock.interrupt)
    clock.process = os.getpid()
    os.dup2(2, 1)
    del sys.argv[1:]  # may name seeds and maps
    threading.Thread(target=_exit_with, args=(parent,), daemon=True).start()
    note_compiling(clock)


def _exit_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(CHECK_INTERVAL)
    os._exit(1)
