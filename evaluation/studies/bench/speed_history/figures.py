"""Figures of ``indoor-explorers bench``, measured by its own code; asv stores them by commit.

asv takes a larger value for a slower one, so speeds are given as times. A figure that a commit lacks is left out.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import ClassVar

from indoor_explorers.evaluation.studies.bench import Benchmark, chosen, measures


@cache
def _benchmarks() -> dict[str, Benchmark]:
    return {benchmark.name: benchmark for benchmark in measures()}


def _names(*patterns: str) -> list[str]:
    return [benchmark.name for benchmark in chosen(list(_benchmarks().values()), patterns)]


class _Figures:
    """Some figures of one unit."""

    param_names: ClassVar[list[str]] = ["figure"]
    timeout: ClassVar[float] = 900.0
    """Seconds for one figure, with what is compiled for it."""

    def setup(self, name: str) -> None:
        """Find the figure; asv leaves out one that raises ``NotImplementedError``."""
        if name not in _benchmarks():
            raise NotImplementedError(name)
        self.take: Callable[[], float] = _benchmarks()[name].take


class _Times(_Figures):
    """Figures that are times, of this unit."""

    unit = "us"

    def track_time(self, name: str) -> float:
        """Return the time in that unit."""
        return self.take()


class AgentStep(_Times):
    """The time of one step of one UAV, on one core."""

    params: ClassVar[list[str]] = _names("world-*-core")

    def track_time(self, name: str) -> float:
        """Return microseconds, from agent-steps a second."""
        return 1e6 / self.take()


class Call(_Times):
    """The time of a scan, of the start of an episode and of a step of the Gymnasium environment."""

    params: ClassVar[list[str]] = _names("lidar-*", "reset-*", "gym-step")


class Decision(_Times):
    """The time of a decision of each policy on a map of 250x250 cells."""

    params: ClassVar[list[str]] = _names("decide-*-250x250")


class Memory(_Figures):
    """The memory of one more episode of a batch."""

    params: ClassVar[list[str]] = _names("memory-*")
    unit = "bytes"

    def track_memory(self, name: str) -> float:
        """Return bytes."""
        return self.take()


class Start(_Times):
    """The time from the start of a process to its first step."""

    params: ClassVar[list[str]] = _names("first-step")
    unit = "s"
