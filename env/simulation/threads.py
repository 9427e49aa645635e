"""Shares of a batch that threads work on in parallel."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait

#: Episodes that make another thread worthwhile; waking a thread takes about as long as stepping this many.
LEAST_SHARE = 16


class Threads:
    """Call compiled work in up to ``count`` threads, this one included."""

    def __init__(self, count: int) -> None:
        self.count = count
        self._pool = ThreadPoolExecutor(count - 1, "world") if count > 1 else None

    def share(self, work: Callable[[int, int, int], object], size: int) -> None:
        """Call ``work(thread, first, last)`` for a share of ``size`` items in each thread, and wait for all."""
        threads = min(self.count, size // LEAST_SHARE + 1)
        if self._pool is None or threads == 1:
            work(0, 0, size)
            return
        bounds = [size * thread // threads for thread in range(threads + 1)]
        others = [self._pool.submit(work, t, bounds[t], bounds[t + 1]) for t in range(1, threads)]
        try:
            work(0, 0, bounds[1])
        finally:
            wait(others)
        for other in others:
            other.result()
