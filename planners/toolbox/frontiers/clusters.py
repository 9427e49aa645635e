"""Frontier clusters: groups of frontier cells so small that one visit explores all cells of a group.

A cluster is a group of 8-connected frontier cells; it is split at its mean, across its principal axis, while a cell
of it is farther than half the lidar range from the mean. Where there are levels, cells are 26-connected, and a cluster
that spreads most from level to level is split between levels.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Distances
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.grid.compiled import inner, kernel
from indoor_explorers.env.grid.levels import on_level
from indoor_explorers.env.search.frontiers import frontier_mask

#: A cluster is split while a cell is farther than this share of the lidar range from its mean.
SPREAD = 0.5


class Clusters(NamedTuple):
    """K clusters of F frontier cells; cluster k is ``cells[ends[k]:ends[k + 1]]``."""

    cells: NDArray[np.int32]
    """(F,) flat cells."""
    ends: NDArray[np.int64]
    """(K + 1,) start index of each cluster, then the end of the last one."""

    @property
    def size(self) -> int:
        """K, the number of clusters."""
        return len(self.ends) - 1


@kernel(entry=False)
def _label(mask: np.ndarray, seed: int, label: int, labels: np.ndarray, queue: np.ndarray, rise: int) -> int:
    """Label the 8-connected part of ``mask`` around flat cell ``seed``; return how many cells it has.

    Unlike the searches of :mod:`indoor_explorers.env.search`, this one goes to all eight neighbours, and to 26 where
    there are levels.
    """
    (height, width), away = mask.shape, 1 if rise > 0 else 0
    head, tail = 0, 1
    queue[0] = seed
    labels[seed // width, seed % width] = label
    while head < tail:
        row, col = divmod(queue[head], width)
        head += 1
        for middle in range(row - away * rise, row + away * rise + 1, max(1, rise)):
            for r in range(max(0, middle - 1), min(height, middle + 2)):
                for c in range(max(0, col - 1), min(width, col + 2)):
                    if mask[r, c] and labels[r, c] == 0:
                        labels[r, c] = label
                        queue[tail] = r * width + c
                        tail += 1
    return tail


class Moments(NamedTuple):
    """Where the cells of a part are, and how they spread."""

    level: float
    """Mean level, 0 where there is one."""
    row: float
    """Mean row."""
    col: float
    """Mean column."""
    largest: float
    """Largest squared distance of a cell to the mean."""
    angle: float
    """Angle of the principal axis among rows and columns."""
    upright: bool
    """Whether the part spreads farther from level to level than along that axis."""


@inner()
def place_of(cell: int, width: int, rise: int) -> tuple[int, int, int]:
    """Return the level, row and column of a flat cell; level 0 where there is one."""
    level, row = on_level(cell // width, rise)
    return level, row, cell % width


@kernel(entry=False)
def mean_place(cells: np.ndarray, width: int, rise: int) -> tuple[float, float, float]:
    """Return the mean level, row and column of flat cells (K,)."""
    level_sum, row_sum, col_sum = 0, 0, 0
    for cell in cells:
        level, row, col = place_of(cell, width, rise)
        level_sum += level
        row_sum += row
        col_sum += col
    count = cells.shape[0]
    return level_sum / count, row_sum / count, col_sum / count


@kernel(entry=False)
def _moments(cells: np.ndarray, width: int, rise: int) -> Moments:
    """Return the moments of flat cells (K,)."""
    count = cells.shape[0]
    level_mean, row_mean, col_mean = mean_place(cells, width, rise)
    ll = rr = rc = cc = largest = 0.0
    for k in range(count):
        level, row, col = place_of(cells[k], width, rise)
        up, down, right = level - level_mean, row - row_mean, col - col_mean
        ll += up * up
        rr += down * down
        rc += down * right
        cc += right * right
        largest = max(largest, down * down + right * right + up * up)
    upright = ll > 0.5 * (rr + cc) + np.hypot(0.5 * (rr - cc), rc)
    return Moments(level_mean, row_mean, col_mean, largest, 0.5 * np.arctan2(2.0 * rc, rr - cc), upright)


@kernel(entry=False)
def _halved(cells: np.ndarray, width: int, rise: int, moments: Moments) -> int:
    """Move the cells on the lower side of the principal axis to the front, in order; return their number."""
    upper, lower = np.empty(cells.shape[0], cells.dtype), 0
    for k in range(cells.shape[0]):
        level, row, col = place_of(cells[k], width, rise)
        along = (row - moments.row) * np.cos(moments.angle) + (col - moments.col) * np.sin(moments.angle)
        if (level - moments.level if moments.upright else along) <= 0.0:
            cells[lower] = cells[k]
            lower += 1
        else:
            upper[k - lower] = cells[k]
    for k in range(lower, cells.shape[0]):
        cells[k] = upper[k - lower]
    return int(max(1, min(lower, cells.shape[0] - 1)))


@kernel(entry=False)
def _split(
    cells: np.ndarray, width: int, rise: int, radius: float, begin: int, end: int, ends: np.ndarray, count: int
) -> int:
    """Split ``cells[begin:end]`` until all parts are small; write their ends; return the new number of clusters."""
    pending = [end]
    while len(pending) > 0:
        part = cells[begin : pending[-1]]
        moments = _moments(part, width, rise)
        if moments.largest > radius * radius + 1e-9:
            pending.append(begin + _halved(part, width, rise, moments))
        else:
            begin = pending.pop()
            ends[count] = begin
            count += 1
    return count


@kernel()
def _clustered(mask: np.ndarray, radius: float, cells: np.ndarray, ends: np.ndarray, rise: int) -> int:
    """Fill ``cells`` (F,) and ``ends`` (F + 1,) of :class:`Clusters`; return how many numbers of ``ends`` count."""
    height, width = mask.shape
    labels, groups = np.zeros((height, width), np.int32), 0
    places = np.zeros(cells.shape[0] + 1, np.int64)  # where each group's next cell goes; group 0 is none
    for row in range(height):
        for col in range(width):
            if mask[row, col] and labels[row, col] == 0:
                groups += 1
                size = _label(mask, row * width + col, groups, labels, cells, rise)
                if groups < cells.shape[0]:
                    places[groups + 1] = places[groups] + size
    for row in range(height):
        for col in range(width):
            if mask[row, col]:
                group = labels[row, col]
                cells[places[group]] = row * width + col
                places[group] += 1
    begin, count = 0, 1
    for group in range(1, groups + 1):
        count = _split(cells, width, rise, radius, begin, places[group], ends, count)
        begin = places[group]
    return int(count)


def frontier_clusters(belief: Belief, lidar_range: float, rise: int = 0) -> Clusters:
    """Return the clusters of all frontier cells of a (H, W) belief, in row-major order of their groups."""
    mask = frontier_mask(belief, rise)
    total = np.count_nonzero(mask)
    cells, ends = np.empty(total, np.int32), np.zeros(total + 1, np.int64)
    return Clusters(cells, ends[: _clustered(mask, SPREAD * lidar_range, cells, ends, rise)])


@kernel()
def _nearest(field: np.ndarray, cells: np.ndarray, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    width = field.shape[1]
    count = ends.shape[0] - 1
    nearest, steps = np.empty(count, np.int32), np.full(count, UNREACHABLE, np.int32)
    for k in range(count):
        nearest[k] = cells[ends[k]]
        for place in range(ends[k], ends[k + 1]):
            cell = cells[place]
            distance = field[cell // width, cell % width]
            if distance < steps[k]:
                nearest[k], steps[k] = cell, distance
    return nearest, steps


def nearest_cells(field: Distances, clusters: Clusters) -> tuple[NDArray[np.int32], Distances]:
    """Return each cluster's nearest cell on a (H, W) distance field, and its distance.

    Both are (K,); cells are flat, the first among equals in row-major order, and the distance is
    ``UNREACHABLE`` if no cell of the cluster is reachable.
    """
    nearest, steps = _nearest(field, clusters.cells, clusters.ends)
    return nearest, steps


@kernel()
def _middles(cells: np.ndarray, ends: np.ndarray, width: int, rise: int) -> np.ndarray:
    middles = np.empty(ends.shape[0] - 1, np.int32)
    for k in range(middles.shape[0]):
        part = cells[ends[k] : ends[k + 1]]
        moments, least = _moments(part, width, rise), np.inf
        for cell in part:
            level, row, col = place_of(cell, width, rise)
            up, down, right = level - moments.level, row - moments.row, col - moments.col
            away = down * down + right * right + up * up
            if away < least:
                middles[k], least = cell, away
    return middles


def middles(clusters: Clusters, width: int, rise: int = 0) -> NDArray[np.int32]:
    """Return each cluster's flat cell nearest to the mean of its cells, (K,); the first among equals."""
    return np.asarray(_middles(clusters.cells, clusters.ends, width, rise))


@kernel()
def _cluster_viewpoints(
    cells: np.ndarray, ends: np.ndarray, nearest: np.ndarray, stride: float
) -> tuple[np.ndarray, np.ndarray]:
    count = ends.shape[0] - 1
    out = np.empty(cells.shape[0] + count, np.int32)
    owner = np.empty(cells.shape[0] + count, np.int64)
    found = 0
    for k in range(count):
        size = ends[k + 1] - ends[k]
        sampled = int(np.ceil(size / max(stride, 1.0)))
        out[found], owner[found] = nearest[k], k
        found += 1
        for s in range(sampled):
            cell = cells[ends[k] + (2 * s + 1) * size // (2 * sampled)]
            if cell != nearest[k]:
                out[found], owner[found] = cell, k
                found += 1
    return out[:found], owner[:found]


def cluster_viewpoints(
    clusters: Clusters, nearest: NDArray[np.int32], stride: float
) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Return (cells, owner): each cluster's nearest cell and one of every ``stride`` others, and their clusters.

    Both are (L,), the cells flat, in the order of the clusters.
    """
    return _cluster_viewpoints(clusters.cells, clusters.ends, nearest, stride)


def first_of_each(owner: NDArray[np.int64], scores: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the index of each owner's best of (L,) scores, (K,), the first among equals; owners in ascending order."""
    order = np.lexsort((-scores, owner))
    return np.asarray(order[np.r_[True, np.diff(owner[order]) > 0]] if len(order) else order)
