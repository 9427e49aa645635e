"""Limits of a worker process on decision time and memory."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

#: Default limit of a decision in seconds.
DECISION_TIMEOUT = 60.0
#: Default share of the machine's memory that all workers together may use.
MEMORY_SHARE = 0.8
#: Bytes of a gigabyte.
GB = 10**9


class Limits(NamedTuple):
    """The limits of one worker."""

    decision_timeout: float | None
    """Seconds that a decision may take; None for no limit."""
    memory: int
    """Bytes of memory that the process may use."""


def limits_for(workers: int, decision_timeout: float | None, memory_limit: float | None) -> Limits:
    """Return the limits of each worker; ``memory_limit`` in GB, None for an equal share of the machine's memory."""
    fair = int(MEMORY_SHARE * machine_memory() / max(1, workers))
    return Limits(decision_timeout, fair if memory_limit is None else int(memory_limit * GB))


def machine_memory() -> int:
    """Return the bytes of memory that this process and its children may use."""
    physical = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    try:
        return min(physical, int(Path("/sys/fs/cgroup/memory.max").read_text()))
    except (OSError, ValueError):  # no control group, or one without a limit
        return physical
