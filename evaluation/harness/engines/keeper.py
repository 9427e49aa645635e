"""The keeper: a process between one that serves and its parent. When either ends, it ends all that the other began.

It is the subreaper of what it keeps: processes whose parents are gone become its children, whatever session they made.
So it finds all of them, and none outlives the command. It runs no code of a policy, and Linux only.
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

#: The most processes and the most threads of what a process serves, itself included.
MOST_PROCESSES, MOST_THREADS = 64, 1024
#: The exit code that tells of more than these.
CROWDED = 97
#: Seconds between two looks at the parent and at the number of processes.
INTERVAL = 0.25
#: Looks for processes that were killed and have not ended yet.
LAST_LOOKS = 40
_PR_SET_PDEATHSIG, _PR_SET_CHILD_SUBREAPER = 1, 36


def begin_kept(parent: int, connection: Connection, most: int = MOST_PROCESSES) -> int:
    """Go on in a child of this process, which stays behind to keep it; return who its parent is.

    ``most``: processes. What this process shares with ``parent``, such as ``connection``, is the child's from now on.
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
    """Have the system refuse processes far beyond those that the user has now; it refuses root none."""
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
    """Hand interruptions on until child or parent ends; then end whatever is left, and end as the child did."""
    tree, status = ProcessTree(os.getpid()), None
    while status is None and os.getppid() == parent:
        told = signal.sigtimedwait((signal.SIGCHLD, signal.SIGUSR1), INTERVAL)
        if told is not None and told.si_signo == signal.SIGUSR1:
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
    """Bury all children that have ended; return the status of this one if it is among them."""
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
