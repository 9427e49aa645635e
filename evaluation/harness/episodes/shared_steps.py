"""The steps of an episode that is flown alone, in memory shared by a worker and its driver.

The driver reads them when the worker, or the process of the policy, has died.
"""

from __future__ import annotations

import mmap
import os

import numpy as np

from indoor_explorers.evaluation.harness.episodes.shared_clock import SharedClock
from indoor_explorers.evaluation.harness.episodes.steps import Steps, step_type


class SharedStepBuffer(SharedClock):
    """Shares a clock, and after it the steps of one episode, between two processes."""

    def begin(self) -> None:
        """Clear the steps of the episode before."""
        os.ftruncate(self._file, mmap.PAGESIZE)

    def add(self, row: np.void) -> None:
        """Append a row of :func:`~.steps.step_type`; the first is the start."""
        os.pwrite(self._file, row.tobytes(), os.fstat(self._file).st_size)

    def steps(self, team: int, base: bool = False) -> Steps:
        """Return the complete steps of an episode of ``team`` UAVs, with a home base or not."""
        kind = step_type(team, base)
        held = os.fstat(self._file).st_size - mmap.PAGESIZE
        return Steps.of(np.frombuffer(os.pread(self._file, held - held % kind.itemsize, mmap.PAGESIZE), kind))
