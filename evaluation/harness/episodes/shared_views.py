"""The views of a batch's UAVs, in memory that a worker shares with the process of their policy."""

from __future__ import annotations

import mmap
import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import View
from indoor_explorers.env.grid.arrays import read_only
from indoor_explorers.env.policies.view import LIVE_ARRAYS, Arrays, arrays_of
from indoor_explorers.env.simulation.rollout import Uav
from indoor_explorers.evaluation.harness.episodes.shared_clock import SharedClock


class SharedViews(SharedClock):
    """Shares a clock, and after it the arrays of views, between the process that writes views and one that reads them.

    Both call :meth:`begin` with the same arguments before a batch. Nobody reads what the reader writes there.
    """

    def begin(
        self, uavs: Sequence[Uav], shape: tuple[int, int], *, writing: bool = False, uncertain: bool = False
    ) -> None:
        """Lay out the arrays of some UAVs on (H, W) maps; those of the batch before show other UAVs from now on.

        ``uncertain``: the maps are of log-odds.
        """
        there = {name: array for name, array in LIVE_ARRAYS.items() if uncertain or not array.uncertain}
        fields = [(name, array.dtype, array.shape_on(shape)) for name, array in there.items()]
        rows = self._rows(len(uavs), np.dtype(fields, align=True), writing=writing)
        shown = np.asarray if writing else read_only
        self.arrays: dict[Uav, Arrays] = {
            uav: tuple(shown(row[name]) if name in there else None for name in LIVE_ARRAYS)
            for uav, row in zip(uavs, rows, strict=True)
        }
        """The arrays of each UAV's latest view; in the reader they are read-only and live."""

    def write(self, uav: Uav, view: View) -> None:
        """Show the arrays of a view to the other process."""
        for shared, array in zip(self.arrays[uav], arrays_of(view), strict=False):
            if shared is not None:
                shared[...] = array

    def _rows(self, count: int, kind: np.dtype[Any], *, writing: bool) -> NDArray[np.void]:
        """Map the memory; it never gets smaller, since a policy may still look at the views of an earlier batch."""
        size = count * kind.itemsize
        if os.fstat(self._file).st_size < mmap.PAGESIZE + size:
            os.ftruncate(self._file, mmap.PAGESIZE + size)
        access = mmap.ACCESS_WRITE if writing else mmap.ACCESS_READ
        return np.frombuffer(mmap.mmap(self._file, size, access=access, offset=mmap.PAGESIZE), kind)
