"""Shows which functions numba is compiling while a comparison waits for them."""

from __future__ import annotations

import time

from indoor_explorers.env.grid.compile_cache import compiling_since, not_compiled
from indoor_explorers.evaluation.drawing.formatting import counted

#: Seconds between two checks of the cache folder.
CHECK_INTERVAL = 0.5


class CompileStatus:
    """Name the functions that are being compiled on this machine, by this process or by workers, and count them."""

    def __init__(self) -> None:
        self._start = time.time() - 1.0  # file systems' clocks may be behind
        self._checked = 0.0
        self._missing: set[str] = set()
        self._line = ""

    def line(self) -> str:
        """Return what is compiled now, and how many functions were of those that the policies may need, or nothing."""
        if time.monotonic() - self._checked >= CHECK_INTERVAL:
            now = compiling_since(self._start)
            self._line = self._told(now) if now else ""
            self._checked = time.monotonic()
        return self._line

    def _told(self, now: set[str]) -> str:
        missing = not_compiled()
        self._missing |= missing
        names = ", ".join(sorted({label.rpartition("-")[0] for label in now}))
        done = len(self._missing) - len(missing)
        return f"compiling {names}: {done} of at most {counted(len(self._missing), 'function')} done, once per machine"
