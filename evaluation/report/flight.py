"""One flown episode packed for the replay: who was where, and which cells became known at each frame.

What the team knew is not stored with results; it is recomputed from the UAVs' cells and the true map,
with the lidar that the world itself uses.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.lidar import new_scan, optics, visible_cells
from indoor_explorers.evaluation.record import Record
from indoor_explorers.evaluation.report.packing import folded, packed, runs


def known_from(record: Record, lidar_range: float) -> NDArray[np.int64]:
    """Return (H * W,) the step from which the team's lidars together knew each cell, -1 for never."""
    truth, lens = record.floorplan.truth, optics(lidar_range)
    width = truth.shape[1]
    known = np.full(truth.size, -1, np.int64)
    scan = new_scan(lens)
    scanned: set[int] = set()
    for step, team in enumerate(record.cells.tolist()):
        for row, column in team:
            if row * width + column in scanned:
                continue
            scanned.add(row * width + column)
            cells = scan.cells[: visible_cells(truth, row, column, lens, scan)]
            known[cells[known[cells] < 0]] = step
    return known


def frame_steps(steps: int, stride: int) -> list[int]:
    """Return the steps that are shown: every ``stride``-th and the last."""
    shown = list(range(0, steps, stride))
    return [*shown, steps]


def pack_flight(record: Record, known: NDArray[np.int64], stride: int) -> bytes:
    """Pack an episode, frame by frame; see :func:`_frame` for what a frame holds."""
    shown = frame_steps(record.steps, stride)
    order = np.argsort(known, kind="stable")
    bounds = np.searchsorted(known[order], [0, *(step + 1 for step in shown)])
    numbers: list[int] = []
    cells = record.cells.astype(np.int64)
    before, covered = np.zeros_like(cells[0]), 0
    for frame, step in enumerate(shown):
        fresh = np.sort(order[bounds[frame] : bounds[frame + 1]])
        now = int(record.covered[step, 0])
        numbers += _frame(cells[step] - before, now - covered, fresh)
        before, covered = cells[step], now
    return packed(numbers)


def _frame(moved: NDArray[np.int64], gained: int, fresh: NDArray[np.int64]) -> Iterator[int]:
    """Yield the moves of each UAV (row, column), the gain in covered cells, and the runs of newly known cells."""
    yield from (folded(change) for change in moved.ravel().tolist())
    yield gained
    lengths = runs(fresh)
    yield len(lengths) // 2
    yield from lengths
