"""Connected parts of a map, cells that can be reached from each other by moves, and trees that connect parts."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Distances, Mask
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.grid.compiled import leaf
from indoor_explorers.env.grid.levels import beside, degree


def connected_parts(free: Mask) -> tuple[Distances, np.ndarray]:
    """Label the parts of a bool mask (H, W) or (L, H, W), 4- or 6-connected; return (labels, cells in each label)."""
    from scipy import ndimage

    labels, count = ndimage.label(free)
    return labels.astype(np.int32), np.bincount(labels.ravel(), minlength=count + 1)


def extent(mask: Mask) -> tuple[slice, slice]:
    """Return the rows and columns of the smallest rectangle around the True cells of a (H, W) mask."""
    lines = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    rows, cols = (slice(int(line[0]), int(line[-1]) + 1) for line in lines)
    return rows, cols


def spanning_tree(pairs: NDArray[np.integer[Any]], weights: NDArray[np.float64], count: int) -> NDArray[np.bool_]:
    """Return which of (n, 2) pairs of ``count`` parts make a minimum spanning tree, (n,); each pair occurs once.

    ``weights`` are (n,); of equal ones the first counts as the smaller one.
    """
    from scipy import sparse  # here, since it takes long to import

    ranks = np.empty(len(weights))
    ranks[np.argsort(weights, kind="stable")] = np.arange(1, len(weights) + 1)
    graph = sparse.coo_array((ranks, (pairs[:, 0], pairs[:, 1])), shape=(count, count)).tocsr()
    return np.isin(ranks, sparse.csgraph.minimum_spanning_tree(graph).data)


@leaf(entry=False)
def label_part(
    truth: np.ndarray, row: int, col: int, label: int, labels: np.ndarray, queue: np.ndarray, rise: int = 0
) -> int:
    """Write ``label`` into ``labels`` (H, W) int32 at every free cell connected to (row, col) that holds 0.

    Returns how many those are; their flat indices are the first entries of ``queue`` (H*W,) int32, nearest first.
    """
    height, width = truth.shape
    labels[row, col] = label
    queue[0] = row * width + col
    head, tail = 0, 1
    while head < tail:
        r, c = divmod(queue[head], width)
        head += 1
        for k in range(degree(rise)):
            rr, cc = beside(r, c, k, rise)
            if 0 <= rr < height and 0 <= cc < width and truth[rr, cc] == FREE and labels[rr, cc] == 0:
                labels[rr, cc] = label
                queue[tail] = rr * width + cc
                tail += 1
    return tail


@leaf(entry=False)
def _root(parents: np.ndarray, run: int) -> int:
    """Return the first run of a run's part, and shorten the way to it."""
    while parents[run] >= 0:
        above = parents[run]
        if parents[above] >= 0:
            parents[run] = parents[above]
        run = above
    return run


@leaf(entry=False)
def _join(parents: np.ndarray, one: int, other: int) -> None:
    """Make the parts of two runs one; the earlier root is its root."""
    one, other = _root(parents, one), _root(parents, other)
    if one != other:
        first, second = min(one, other), max(one, other)
        parents[first] += parents[second]
        parents[second] = first


@leaf(entry=False)
def _join_runs(truth: np.ndarray, part: np.ndarray, parents: np.ndarray) -> int:
    """Write into ``part`` at every free cell the number of its run, from 1 on; return the number of runs.

    A run is a longest row of free cells side by side. ``parents`` [n - 1] becomes a root's minus the number of cells of
    its part, and an earlier run of the same part, counted from 0, for all other runs n.
    """
    height, width = truth.shape
    runs = 0
    for row in range(height):
        more = joined = 0
        for col in range(width):
            if truth[row, col] != FREE:
                part[row, col] = joined = 0
                continue
            if col == 0 or part[row, col - 1] == 0:
                parents[runs] = -1
                runs += 1
                more = 0
            else:
                more += 1
            part[row, col] = runs
            above = part[row - 1, col] if row > 0 else 0
            if above > 0 and above != joined:
                _join(parents, runs - 1, above - 1)
            joined = above
            if more > 0 and (col + 1 == width or truth[row, col + 1] != FREE):
                parents[_root(parents, runs - 1)] -= more
    return runs


@leaf()
def mark_largest_part(truth: np.ndarray, part: np.ndarray, queue: np.ndarray) -> int:
    """Write 1 into ``part`` (H, W) int32 on the largest connected free part, 0 elsewhere; return its size.

    Among parts of equal size, the first in reading order is taken. ``queue`` (H*W,) int32 is scratch. The runs of free
    cells in the rows are joined by union-find, which takes a third of the time of a flood.
    """
    height, width = truth.shape
    runs = _join_runs(truth, part, queue)
    largest = most = 0
    for run in range(runs):
        if queue[run] >= 0:
            queue[run] = queue[run] if queue[queue[run]] < 0 else queue[queue[run]]
        elif -queue[run] > most:
            largest, most = run, -queue[run]
    for row in range(height):
        for col in range(width):
            run = part[row, col] - 1
            part[row, col] = run >= 0 and (run == largest or queue[run] == largest)
    return most


def largest_part(free: Mask) -> Mask:
    """Return the mask of the largest 4-connected part of ``free`` (H, W); all False when nothing is free.

    Of a volume (L, H, W), it is the largest 6-connected part.
    """
    if free.ndim > 2:
        labels, sizes = connected_parts(free)
        return np.asarray(labels == 1 + np.argmax(sizes[1:])) if len(sizes) > 1 else free.copy()
    part = np.empty(free.shape, np.int32)
    mark_largest_part(free.astype(np.uint8) * FREE, part, np.empty(free.size, np.int32))
    return np.asarray(part == 1)
