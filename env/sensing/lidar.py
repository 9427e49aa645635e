"""The lidar: the cells in view of a scan, by one of two models.

``exact`` is line of sight, see :mod:`indoor_explorers.env.sensing.shadowcasting`; ``marsexplorer`` is the rule of
MarsExplorer, see :mod:`indoor_explorers.env.sensing.marsexplorer`. Ranges are in cells, Euclidean to a cell's centre,
and only ``OCCUPIED`` blocks: on a belief map, unknown cells are transparent. Over several levels ``exact`` is that of
:mod:`indoor_explorers.env.sensing.volume`.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.sensing.marsexplorer import SAMPLES, directions, trace
from indoor_explorers.env.sensing.shadowcasting import Quadrant, scan_quadrant
from indoor_explorers.env.sensing.volume import scan_volume
from indoor_explorers.env.sensing.volume_tables import VolumeTables, volume_tables


class LidarModel(NamedTuple):
    """Constants of one lidar model and range for compiled code."""

    range: float
    """Cells."""
    half_widths: NDArray[np.int64]
    """(R + 1,) cells to each side that are in range, R = 0, 1, ... rows away from the sensor."""
    rays: NDArray[np.float64]
    """(K, 2) directions (rows, columns) of the rays; none in the exact model."""
    disc: int
    """Cells in range, the own left out."""
    volume: VolumeTables
    """What it sees over several levels."""


class Scan(NamedTuple):
    """Working arrays of a scan, not to be shared between threads."""

    cells: NDArray[np.int64]
    """The flat indices of the cells seen."""
    arcs: NDArray[np.int64]
    """(2, K, 6) open directions."""


@lru_cache(maxsize=32)
def lidar_model(lidar_range: float, model: str = "exact", levels: int = 1, elevation: float = 90.0) -> LidarModel:
    """Return the constants of a lidar range in cells and a model, ``exact`` or ``marsexplorer``.

    Over several ``levels`` the lidar sees at most ``elevation`` degrees up and down; the model is ``exact``.
    """
    volume = volume_tables(lidar_range, levels, elevation)
    away = np.arange(int(lidar_range + 1e-9) + 1)
    half_widths = np.sqrt(np.maximum(lidar_range**2 - away**2, 0) + 1e-9).astype(np.int64)
    return LidarModel(
        range=float(lidar_range),
        half_widths=half_widths,
        rays=directions() if model == "marsexplorer" else np.empty((0, 2)),
        disc=(len(volume.begins) - 1) // 3
        if levels > 1
        else int(2 * (2 * half_widths + 1).sum() - (2 * half_widths[0] + 1) - 1),
        volume=volume,
    )


def model_of(lidar: LidarModel | float) -> LidarModel:
    """Return a lidar given as its constants, or as its range on maps of one level."""
    return lidar if isinstance(lidar, LidarModel) else lidar_model(float(lidar))


@kernel()
def new_scan(lidar: LidarModel) -> Scan:
    """Allocate the working arrays of scans."""
    room = max(4 * lidar.disc, lidar.rays.shape[0] * SAMPLES) + 1
    arcs = 1
    for away in range(lidar.half_widths.shape[0]):
        arcs += min(away, lidar.half_widths[away] + 1) + 1
    return Scan(np.empty(room, np.int64), np.empty((2 * arcs, 6), np.int64))


@leaf()
def visible_cells(occupancy: np.ndarray, row: int, col: int, lidar: LidarModel, scan: Scan) -> int:
    """List the cells seen from (row, col): fills ``scan.cells`` with flat indices and returns how many.

    ``occupancy`` is (H, W) uint8, C-contiguous. The own cell comes first. An obstacle may be listed twice, and so
    may any cell in the model ``marsexplorer``.
    """
    return newly_visible_cells(occupancy, occupancy[:0], row, col, lidar, scan)


@leaf()
def newly_visible_cells(
    occupancy: np.ndarray, known: np.ndarray, row: int, col: int, lidar: LidarModel, scan: Scan
) -> int:
    """List the cells seen from (row, col) as :func:`visible_cells` does, for callers that pass over known cells.

    Those that are not 0 in ``known`` (H, W) uint8, C-contiguous, are left out over several levels, where this is
    quicker; on plain maps they are listed.
    """
    height, width = occupancy.shape
    cells, widths, arcs, out = occupancy.reshape(height * width), lidar.half_widths, scan.arcs, scan.cells
    origin = row * width + col
    out[0] = origin
    if lidar.volume.levels > 0:
        return scan_volume(occupancy, known, row, col, lidar.volume, out)
    if lidar.rays.shape[0] > 0:
        return trace(occupancy, row, col, lidar.range, lidar.rays, out)
    seen = scan_quadrant(
        cells, Quadrant(origin, width, 1, height - 1 - row, -col, width - 1 - col, True), widths, arcs, out, 1
    )
    seen = scan_quadrant(cells, Quadrant(origin, -width, 1, row, -col, width - 1 - col, True), widths, arcs, out, seen)
    seen = scan_quadrant(
        cells, Quadrant(origin, 1, width, width - 1 - col, -row, height - 1 - row, False), widths, arcs, out, seen
    )
    return scan_quadrant(
        cells, Quadrant(origin, -1, width, col, -row, height - 1 - row, False), widths, arcs, out, seen
    )


@leaf()
def unknown_in_view(belief: np.ndarray, row: int, col: int, lidar: LidarModel, scan: Scan) -> int:
    """Count the unknown cells that a scan at (row, col) could reveal, unknown taken as transparent."""
    cells = belief.reshape(belief.size)
    gain = 0
    for k in range(1, newly_visible_cells(belief, belief, row, col, lidar, scan)):  # the own cell reveals nothing
        gain += cells[scan.cells[k]] == UNKNOWN
    return gain


def view_gain(belief: Belief, cell: tuple[int, int], lidar_range: LidarModel | float) -> int:
    """Return how many unknown cells are visible from ``cell`` on a (H, W) belief map, by a lidar or its range."""
    lidar = model_of(lidar_range)
    return int(unknown_in_view(belief, cell[0], cell[1], lidar, new_scan(lidar)))


def scan(truth: Belief, cell: tuple[int, int], lidar_range: LidarModel | float, model: str = "exact") -> Belief:
    """Return the (H, W) belief after one scan of ``truth`` at ``cell``, everything else unknown.

    The lidar is given as such, or by its range and a ``model`` of this package; those of plug-ins scan themselves.
    """
    lidar = lidar_range if isinstance(lidar_range, LidarModel) else lidar_model(float(lidar_range), model)
    work = new_scan(lidar)
    seen = work.cells[: visible_cells(truth, cell[0], cell[1], lidar, work)]
    belief = np.full(truth.shape, UNKNOWN, np.uint8)
    belief.flat[seen] = np.where(truth.flat[seen] == OCCUPIED, OCCUPIED, FREE)
    return belief
