"""What numba compiles while a comparison waits for it."""

from __future__ import annotations

import time

from indoor_explorers.env.grid.compile_cache import compiling_since, not_compiled
from indoor_explorers.evaluation.report.style.formatting import counted

#: Seconds between two looks at the cache folder.
EVERY = 0.5


class CompileStatus:
    """Name the functions that are being compiled on this machine, by this process or by workers."""

    def __init__(self) -> None:
        self._start = time.time() - 1.0  # file systems' clocks may be behind
        self._looked = 0.0
        self._seen: set[str] = set()
        self._total = 0
        self._line = ""

    def line(self) -> str:
        """Return what is compiled now, and how many functions were of those that the policies may need, or nothing."""
        if time.monotonic() - self._looked >= EVERY:
            now = compiling_since(self._start)
            self._seen.update(now)
            if now and not self._total:
                self._total = len(not_compiled() | now)
            names = ", ".join(sorted({label.rpartition("-")[0] for label in now}))
            count = f"{len(self._seen)} of at most {counted(max(self._total, len(self._seen)), 'function')}"
            self._line = f"compiling {names}: {count}, once per machine" if now else ""
            self._looked = time.monotonic()
        return self._line
