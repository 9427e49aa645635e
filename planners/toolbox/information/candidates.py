"""Candidates: cells that a group of UAVs could fly to next, their view gains, and the distances between them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Distances
from indoor_explorers.env.grid.cells import FREE, UNKNOWN, UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.grid.levels import beside, degree, rise_of
from indoor_explorers.env.search.bfs import flood, flood_nearby
from indoor_explorers.env.sensing.lidar import (
    LidarModel,
    Scan,
    model_of,
    new_scan,
    newly_visible_cells,
    unknown_in_view,
)
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters, nearest_cells
from indoor_explorers.planners.toolbox.information.view_gain import AROUND, known_around

Cells = NDArray[np.int32]
Table = NDArray[np.float64]


class UnknownWeight(NamedTuple):
    """Parameters of the weight of an unknown cell: (1 + isolation k / 24) e^(-depth / decay_length)."""

    isolation: float
    """Weight of k, the number of cells in its 5x5 neighbourhood that are known or off the map; over several levels the
    share in its cube of 5x5x5, times 24."""
    decay_length: float
    """Length in cells; the depth is the cell's distance from known free space through unknown cells."""


@leaf()
def depths(belief: np.ndarray, queue: np.ndarray, out: np.ndarray, rise: int = 0) -> None:
    """Fill ``out`` (H, W) int32 with each unknown cell's steps from known free space through unknown cells.

    Other cells get ``UNREACHABLE``. ``queue`` is scratch, (H*W,) int32.
    """
    height, width = belief.shape
    out[:] = UNREACHABLE
    tail = 0
    for row in range(height):
        for col in range(width):
            for k in range(degree(rise) if belief[row, col] == FREE else 0):
                r, c = beside(row, col, k, rise)
                if 0 <= r < height and 0 <= c < width and belief[r, c] == UNKNOWN and out[r, c] > 1:
                    out[r, c] = 1
                    queue[tail] = r * width + c
                    tail += 1
    flood(belief, UNKNOWN, tail, queue, out, rise)


@leaf()
def cell_weight(belief: np.ndarray, depth: np.ndarray, cell: int, weight: UnknownWeight, rise: int = 0) -> float:
    """Return the weight of a flat unknown cell of a (H, W) belief; ``depth`` (H, W) is filled by :func:`depths`."""
    row, col = divmod(cell, belief.shape[1])
    isolated = 1.0 + weight.isolation * known_around(belief, row, col, rise) / AROUND
    return float(isolated * np.exp(-depth[row, col] / weight.decay_length))


@kernel(entry=False)
def _visible_unknown(
    belief: np.ndarray, cells: np.ndarray, depth: np.ndarray, weight: UnknownWeight, lidar: LidarModel, scan: Scan
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the unknown cells in view of each candidate, (K, disc + 1), their number, (K,), and all cells' weights."""
    width, rise = belief.shape[1], rise_of(belief.shape[0], lidar.volume.levels)
    lists, sizes = np.empty((cells.shape[0], lidar.disc + 1), np.int32), np.zeros(cells.shape[0], np.int64)
    value = np.zeros(belief.size)
    for k in range(cells.shape[0]):
        for place in range(newly_visible_cells(belief, belief, cells[k] // width, cells[k] % width, lidar, scan)):
            cell = scan.cells[place]
            if belief[cell // width, cell % width] == UNKNOWN:
                if value[cell] == 0.0:
                    value[cell] = cell_weight(belief, depth, cell, weight, rise)
                lists[k, sizes[k]] = cell
                sizes[k] += 1
    return lists, sizes, value


@kernel()
def candidate_views(
    belief: np.ndarray, cells: np.ndarray, weight: UnknownWeight, lidar: LidarModel
) -> tuple[np.ndarray, np.ndarray]:
    """Return the view gains of (K,) flat cells, (K,), and the share of each view that each other cell has, (K, K).

    A view gain is the sum of the weights of the unknown cells in view; unknown cells are transparent.
    """
    depth, mark = np.empty(belief.shape, np.int32), np.empty(belief.size, np.int32)
    depths(belief, mark, depth, rise_of(belief.shape[0], lidar.volume.levels))
    lists, sizes, value = _visible_unknown(belief, cells, depth, weight, lidar, new_scan(lidar))
    count = cells.shape[0]
    shared = np.zeros((count, count))
    mark[:] = -1
    for k in range(count):
        for place in range(sizes[k]):
            mark[lists[k, place]] = k
        for j in range(k + 1):
            for place in range(sizes[j]):
                if mark[lists[j, place]] == k:
                    shared[k, j] += value[lists[j, place]]
            shared[j, k] = shared[k, j]
    gains = np.empty(count)
    for k in range(count):
        gains[k] = shared[k, k]
        for j in range(count):  # sums in another order may round to more than 1
            shared[k, j] = min(shared[k, j] / max(gains[k], 1e-300), 1.0)
    return gains, shared


@kernel()
def distances_between(
    belief: np.ndarray, cells: np.ndarray, steps: np.ndarray, limit: int, rise: int = 0
) -> np.ndarray:
    """Return the steps between (K,) flat cells, (K, K).

    Distances above ``limit`` are replaced by an upper bound: the path through a UAV's position, from the (N, K)
    distances ``steps``.
    """
    count = cells.shape[0]
    queue, out = np.empty(belief.size, np.int32), np.full(belief.size, UNREACHABLE, np.int32)
    between = np.empty((count, count))
    for k in range(count):
        reached = flood_nearby(belief, cells[k], -1, limit, queue, out, rise)
        for j in range(count):
            between[k, j] = out[cells[j]]
            if between[k, j] >= UNREACHABLE:
                for i in range(steps.shape[0]):
                    between[k, j] = min(between[k, j], steps[i, k] + steps[i, j])
        for place in range(reached):
            out[queue[place]] = UNREACHABLE
    return between


@kernel()
def _gains(belief: np.ndarray, cells: np.ndarray, lidar: LidarModel) -> np.ndarray:
    gains, scan, width = np.empty(cells.shape[0], np.int64), new_scan(lidar), belief.shape[1]
    for k in range(cells.shape[0]):
        gains[k] = unknown_in_view(belief, cells[k] // width, cells[k] % width, lidar, scan)
    return gains


def frontier_candidates(belief: Belief, fields: Distances, lidar_range: float, most: int, rise: int = 0) -> Cells:
    """Return, for each of the ``most`` frontier clusters nearest to the group, its flat cell nearest to the group.

    ``fields`` is (N, H, W), each UAV's steps.
    """
    cells, steps = nearest_cells(fields.min(axis=0), frontier_clusters(belief, lidar_range, rise))
    order = np.argsort(steps, kind="stable")[:most]
    return cells[order[steps[order] < UNREACHABLE]]


def local_candidates(
    belief: Belief, fields: Distances, lidar_range: LidarModel | float, reach: int, rate: float, most: int
) -> Cells:
    """Return flat known cells at most ``reach`` steps from a UAV that have unknown cells in view, (K,).

    For each UAV the ``most`` cells with the largest sqrt(view gain) e^(-rate steps): a UAV need not fly to a frontier
    that it can view from nearby. ``fields`` (N, H, W) are the steps from N UAVs; the
    lidar is given as such or by its range.
    """
    flat = fields.reshape(len(fields), -1)
    cells = np.flatnonzero(((flat > 0) & (flat <= reach)).any(axis=0)).astype(np.int32)
    gains, steps = _gains(belief, cells, model_of(lidar_range)), flat[:, cells]
    value = np.where(steps <= reach, np.sqrt(gains) * np.exp(-rate * np.minimum(steps, reach)), 0.0)
    kept = np.zeros(len(cells), np.bool_)
    for row in value:
        kept[np.argsort(-row, kind="stable")[:most]] = True
    return cells[kept & (gains > 0)]
