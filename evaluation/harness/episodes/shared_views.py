"""The views of a batch's UAVs, in memory that a worker shares with the process of their policy."""

from __future__ import annotations

import mmap
import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import View
from indoor_explorers.env.grid.arrays import Belief, Mask, read_only
from indoor_explorers.env.simulation.rollout import Uav
from indoor_explorers.evaluation.harness.episodes.shared_clock import SharedClock

#: Belief, legal moves, visited cells, and log-odds where maps can be wrong.
Shown = tuple[Belief, Mask, Mask, NDArray[np.float32] | None]


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
        rows = self._rows(len(uavs), shape, writing=writing, uncertain=uncertain)
        shown = np.asarray if writing else read_only
        self._shown: dict[Uav, Shown] = {
            uav: (
                shown(row["belief"]),
                shown(row["legal"]),
                shown(row["visited"]),
                shown(row["log_odds"]) if uncertain else None,
            )
            for uav, row in zip(uavs, rows, strict=True)
        }

    def write(self, uav: Uav, view: View) -> None:
        """Show the arrays of a view to the other process."""
        belief, legal, visited, log_odds = self._shown[uav]
        belief[...], legal[...], visited[...] = view.belief, view.legal, view.visited
        if log_odds is not None:
            log_odds[...] = view.log_odds

    def arrays(self, uav: Uav) -> Shown:
        """Return belief, legal moves, visited cells and log-odds of a UAV's latest view; read-only and live."""
        return self._shown[uav]

    def _rows(self, count: int, shape: tuple[int, int], *, writing: bool, uncertain: bool) -> NDArray[np.void]:
        """Map the memory; it never gets smaller, since a policy may still look at the views of an earlier batch."""
        kind: np.dtype[Any] = np.dtype(
            [("log_odds", np.float32, shape)] * uncertain
            + [("belief", np.uint8, shape), ("visited", np.bool_, shape), ("legal", np.bool_, (5,))]
        )
        size = count * kind.itemsize
        if os.fstat(self._file).st_size < mmap.PAGESIZE + size:
            os.ftruncate(self._file, mmap.PAGESIZE + size)
        access = mmap.ACCESS_WRITE if writing else mmap.ACCESS_READ
        return np.frombuffer(mmap.mmap(self._file, size, access=access, offset=mmap.PAGESIZE), kind)
