"""The keeper: a process between a serving process and its parent, which ends all descendants when either ends.

It is their subreaper: orphaned descendants become its children, whatever session they are in. So it finds all of them,
and none outlives the command. It runs no code of a policy, and exists on Linux only.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import resource
import signal
import sys
from multiprocessing.connection import Connection
from typing import NoReturn

from indoor_explorers.evaluation.harness.engines.process_tree import PROC, ProcessTree, all_pids, process_of

#: The most processes and the most threads of a serving process, itself included.
MOST_PROCESSES, MOST_THREADS = 64, 1024
#: The exit code of a keeper whose process had more than these.
CROWDED = 97
#: Seconds between two checks of the parent and of the number of processes.
INTERVAL = 0.25
#: Checks for processes that were killed and have not ended yet.
LAST_LOOKS = 40
_PR_SET_PDEATHSIG, _PR_SET_CHILD_SUBREAPER = 1, 36


def begin_kept(parent: int, connection: Connection, most: int = MOST_PROCESSES) -> int:
    """Fork this process: continue in the child, whose keeper this process becomes; return the child's parent.

    ``most`` limits the number of processes. What this process shares with ``parent``, such as ``connection``, passes to
    the child.
    """
    if sys.platform != "linux":
        return parent
    ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1)
    keeper, before = os.getpid(), signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
    if child := os.fork():
        connection.close()
        _keep(child, parent, most)
    signal.pthread_sigmask(signal.SIG_SETMASK, before)
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, int(signal.SIGKILL))
    if os.getppid() != keeper:
        os._exit(1)
    with contextlib.suppress(ValueError, OSError):
        _limit_processes()
    return keeper


def _limit_processes() -> None:
    """Have the system refuse many more processes than the user has now; root is exempt."""
    mine = [process for pid in all_pids() if _is_mine(pid) and (process := process_of(pid))]
    _, hard = resource.getrlimit(resource.RLIMIT_NPROC)
    most = sum(process.threads for process in mine) + 2 * MOST_THREADS
    if hard == resource.RLIM_INFINITY or most < hard:
        resource.setrlimit(resource.RLIMIT_NPROC, (most, hard))


def _is_mine(pid: int) -> bool:
    try:
        return (PROC / str(pid)).stat().st_uid == os.getuid()
    except OSError:
        return False


def _keep(child: int, parent: int, most: int) -> NoReturn:
    """Forward interruptions until child or parent ends; then kill all descendants, and exit as the child did."""
    tree, status = ProcessTree(os.getpid()), None
    while status is None and os.getppid() == parent:
        received = signal.sigtimedwait((signal.SIGCHLD, signal.SIGUSR1), INTERVAL)
        if received is not None and received.si_signo == signal.SIGUSR1:
            os.kill(child, signal.SIGUSR1)
        elif len(tree.update()) > most or tree.threads() > MOST_THREADS:
            tree.kill()
            status = CROWDED << 8
        status = status or _reaped(child)
    tree.kill()
    for _ in range(LAST_LOOKS):
        if not tree.update():
            break
        _reaped(child)
        signal.sigtimedwait((signal.SIGCHLD,), INTERVAL / 10)
    _end_as(status)


def _reaped(child: int) -> int | None:
    """Reap all children that have ended; return the status of ``child`` if it is among them."""
    status = None
    with contextlib.suppress(ChildProcessError):
        while (ended := os.waitpid(-1, os.WNOHANG))[0]:
            status = ended[1] if ended[0] == child else status
    return status


def _end_as(status: int | None) -> NoReturn:
    if status is not None and os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        with contextlib.suppress(OSError, ValueError):
            signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [number])
    os._exit(1 if status is None else os.waitstatus_to_exitcode(status) % 256)
