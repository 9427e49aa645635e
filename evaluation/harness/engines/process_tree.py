"""The descendants of a process and their memory, from Linux's /proc; other systems have none of this."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

PROC = Path("/proc")
#: Attempts to stop a whole tree; each finds the processes that were started during the one before.
ROUNDS = 200


class Process(NamedTuple):
    """The facts of a process in /proc."""

    state: str
    """One letter: ``T`` and ``t`` for stopped."""
    parent: int
    threads: int
    started: int
    """Clock ticks since the machine started: identifies a process, together with its number."""


def process_of(pid: int) -> Process | None:
    """Return the facts of a process, None if it has ended or there is no /proc."""
    try:
        words = (PROC / str(pid) / "stat").read_bytes().rpartition(b")")[2].split()
    except OSError:
        return None
    if len(words) < 20 or words[0] in (b"Z", b"X"):
        return None
    return Process(words[0].decode(), int(words[1]), int(words[17]), int(words[19]))


def all_pids() -> set[int]:
    """Return the numbers of all processes of the machine; none without /proc."""
    try:
        with os.scandir(PROC) as entries:
            return {int(entry.name) for entry in entries if entry.name.isdecimal()}
    except OSError:
        return set()


class ProcessTree:
    """The descendants of a process; once found, they stay members when their parents end.

    Can be used by several threads: sets are replaced, never changed.
    """

    def __init__(self, root: int) -> None:
        self._root, self._born = root, process_of(root)
        self._others: set[int] = set()
        self._started: dict[int, int] = {}

    def update(self) -> set[int]:
        """Find and return the descendants that run now; only new processes are examined."""
        present = all_pids() - {self._root}
        self._others = self._others & present
        found = {pid: process for pid in present - self._others if (process := process_of(pid))}
        self._started = {
            pid: started for pid, started in self._started.items() if pid in found and found[pid].started == started
        }
        now, new = process_of(self._root), found.keys() - self._started.keys()
        roots = {self._root} if now and self._born and now.started == self._born.started else set()
        while more := {pid for pid in new if found[pid].parent in self._started.keys() | roots}:
            self._started = self._started | {pid: found[pid].started for pid in more}
            new -= more
        self._others = self._others | new
        return set(self._started)

    def threads(self) -> int:
        """Return the number of threads of the members that :meth:`update` found last."""
        return sum(process.threads for pid in self._started if (process := process_of(pid)))

    def kill(self) -> bool:
        """Kill all members, and return whether there were any; they are stopped first, so that none starts another."""
        stopped: set[int] = set()
        for _ in range(ROUNDS):
            self._others = set()
            if not (running := self.update() - stopped):
                break
            _signal(running, signal.SIGSTOP)
            stopped |= running
        _signal(stopped, signal.SIGKILL)
        return bool(stopped)


def _signal(pids: Iterable[int], number: signal.Signals) -> None:
    for pid in pids:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.kill(pid, number)


def busy_time(pid: int) -> float | None:
    """Return the seconds that the threads of a process ran or waited for a core, None without /proc."""
    times = [_words(path) for path in (PROC / str(pid) / "task").glob("*/schedstat")]
    return sum(ran + waited for ran, waited, *_ in times) / 1e9 if times else None


def memory_of(pids: Iterable[int], limit: float = 0.0) -> int:
    """Return the bytes of memory that processes use together, 0 without /proc.

    Pages that several of them share count once, as do anonymous files in memory, mapped or not. If the sum of what each
    uses, shared pages included, is at most ``limit``, that is returned, which is quicker.
    """
    held = [PROC / str(pid) for pid in pids]
    files = _memory_files(held)
    resident = sum(_words(each / "statm")[1] for each in held) * os.sysconf("SC_PAGE_SIZE")
    shares = [] if resident + files <= limit else [_words(each / "smaps_rollup", "Pss:", "Pss_Shmem:") for each in held]
    if not any(whole for whole, _ in shares):
        return resident + files
    return 1024 * sum(whole for whole, _ in shares) + max(0, files - 1024 * sum(shared for _, shared in shares))


def _memory_files(processes: Iterable[Path]) -> int:
    """Return the bytes of the anonymous files in memory (memfd) that processes have open."""
    found: dict[int, int] = {}
    for each in processes:
        with contextlib.suppress(OSError):  # the process or the file does not exist any more
            for entry in list((each / "fd").iterdir()):
                if str(entry.readlink()).startswith("/memfd:"):
                    file = entry.stat()
                    found[file.st_ino] = 512 * file.st_blocks
    return sum(found.values())


def _words(path: Path, *names: str) -> list[int]:
    """Return the numbers in the first line of a file, or those of the lines with these names; zeros if missing."""
    try:
        lines = [line.split() for line in path.read_text().splitlines()]
    except OSError:
        lines = []
    if names:
        return [next((int(line[1]) for line in lines if line[0] == name), 0) for name in names]
    return [int(word) for word in lines[0]] if lines else [0, 0]
