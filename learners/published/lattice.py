"""Lattice graphs of published exploration networks: lines, frontier points, sightings and nearest nodes.

ARiADNE, IR2 and MARVEL spread nodes on a lattice over the known free space, join near ones by straight lines, and count
the frontier points in view of each. A line visits one cell after the other along rows and columns, so every edge can be
flown on a grid. All points are (row, column) cells; ``reach`` and other lengths are in cells.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.compiled import kernel, leaf

Points = NDArray[np.int64]
Indices = NDArray[np.int64]
#: Neighbours asked for beyond k, so that those at equal distances are ordered by number.
_TIES = 8


@leaf(entry=False)
def _clear(belief: np.ndarray, row: int, col: int, to_row: int, to_col: int) -> bool:
    """Tell whether all cells of a line but the last one are known and free; a step goes along one axis."""
    down, right = abs(to_row - row), abs(to_col - col)
    error = right - down
    along_rows, along_cols = 1 if to_row > row else -1, 1 if to_col > col else -1
    while row != to_row or col != to_col:
        if belief[row, col] != FREE:
            return False
        if error > 0:
            col += along_cols
            error -= 2 * down
        else:
            row += along_rows
            error += 2 * right
    return True


@kernel()
def clear_lines(belief: np.ndarray, starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return which lines from (N, 2) to (N, 2) cells are clear, (N,) bool: known and free up to the last cell."""
    out = np.empty(starts.shape[0], np.bool_)
    for n in range(starts.shape[0]):
        out[n] = _clear(belief, starts[n, 0], starts[n, 1], ends[n, 0], ends[n, 1])
    return out


@kernel()
def sightings(belief: np.ndarray, nodes: np.ndarray, points: np.ndarray, reach: float) -> np.ndarray:
    """Return the pairs (P, 2) of a node and a point nearer than ``reach`` with a clear line from the node to it."""
    count = 0
    for n in range(nodes.shape[0]):
        for p in range(points.shape[0]):
            count += (nodes[n, 0] - points[p, 0]) ** 2 + (nodes[n, 1] - points[p, 1]) ** 2 < reach * reach
    out, count = np.empty((count, 2), np.int64), 0
    for n in range(nodes.shape[0]):
        for p in range(points.shape[0]):
            away = (nodes[n, 0] - points[p, 0]) ** 2 + (nodes[n, 1] - points[p, 1]) ** 2
            if away < reach * reach and _clear(belief, nodes[n, 0], nodes[n, 1], points[p, 0], points[p, 1]):
                out[count, 0], out[count, 1] = n, p
                count += 1
    return out[:count]


@kernel()
def _blocks(belief: np.ndarray, side: int) -> np.ndarray:
    """Return a belief in blocks of ``side`` cells: free if all cells are, else unknown if none is occupied."""
    out = np.full(((belief.shape[0] + side - 1) // side, (belief.shape[1] + side - 1) // side), OCCUPIED, np.uint8)
    for r in range(belief.shape[0] // side):
        for c in range(belief.shape[1] // side):
            kind = FREE
            for k in range(side * side):
                found = belief[r * side + k // side, c * side + k % side]
                if found == OCCUPIED or kind == OCCUPIED:
                    kind = OCCUPIED
                elif found == UNKNOWN:
                    kind = UNKNOWN
            out[r, c] = kind
    return out


@kernel()
def _frontier_blocks(blocks: np.ndarray) -> np.ndarray:
    height, width = blocks.shape
    out = np.zeros((height, width), np.bool_)
    for r in range(height):
        for c in range(width):
            if blocks[r, c] == FREE:
                unknown = 0
                for i in range(max(0, r - 1), min(height, r + 2)):
                    for j in range(max(0, c - 1), min(width, c + 2)):
                        unknown += blocks[i, j] == UNKNOWN
                out[r, c] = 1 < unknown < 8
    return out


def frontier_points(belief: NDArray[np.uint8], side: int) -> Points:
    """Return the frontier points (P, 2): first cells of free blocks with 2 to 7 unknown ones among the 8 around."""
    found = _frontier_blocks(_blocks(belief, side) if side > 1 else belief)
    return np.argwhere(found) * side


def lattice_points(shape: tuple[int, int], spacing: tuple[float, float]) -> Points:
    """Return the points (N, 2) of a lattice on an (H, W) map, column by column; ``spacing`` is in cells."""
    rows, cols = (
        np.unique(np.round(np.arange(int((size - 1) / step + 1e-9) + 1) * step).astype(np.int64))
        for size, step in zip(shape, spacing, strict=True)
    )
    return np.stack([np.tile(rows, len(cols)), np.repeat(cols, len(rows))], axis=1)


def nearest(points: Points, to: Points, k: int) -> Indices:
    """Return the k nearest of (N, 2) points to each of (M, 2), nearest first, by number at equal distance, (M, K)."""
    asked = min(k + _TIES, len(points))
    _, found = cKDTree(points).query(to, asked)
    found = found.reshape(len(to), asked)
    away = np.square(points[found] - to[:, None]).sum(axis=-1)
    order = np.lexsort((found, away), axis=-1)[:, :k]
    return np.take_along_axis(found, order, axis=1)


def straight_edges(belief: NDArray[np.uint8], nodes: Points, near: Indices) -> Indices:
    """Return the nodes ``near`` (N, K) to each node that a clear line leads to, in this order, (N, K), -1 for none."""
    starts, ends = np.repeat(nodes, near.shape[1], axis=0), nodes[np.maximum(near, 0)].reshape(-1, 2)
    joined = clear_lines(belief, starts, ends).reshape(near.shape) & (near >= 0)
    return moved_left(np.where(joined, near, -1))


def moved_left(near: Indices) -> Indices:
    """Return the rows of (N, K) indices with those of -1 last."""
    return np.take_along_axis(near, np.argsort(near < 0, axis=1, kind="stable"), axis=1)


def pairs_of(near: Indices) -> Indices:
    """Return the edges of (N, K) neighbours, -1 for none, as pairs (P, 2) of nodes."""
    rows, places = np.nonzero(near >= 0)
    return np.stack([rows, near[rows, places]], axis=1)


def walks(nodes: Points, near: Indices, start: int) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return the lengths (N,) of shortest walks along the edges, either way, and the node before each, (N,)."""
    rows, ends = pairs_of(near).T
    lengths = np.maximum(np.hypot(*(nodes[rows] - nodes[ends]).T), 1e-9)
    graph = csr_array((lengths, (rows, ends)), shape=(len(nodes), len(nodes)))
    found, before = dijkstra(graph, directed=False, indices=[start], return_predecessors=True)
    return found[0], before[0]


def walk_to(before: NDArray[np.int32], end: int) -> list[int]:
    """Return the nodes of the walk to a node, the first one included."""
    walk = [end]
    while before[walk[-1]] >= 0:
        walk.append(int(before[walk[-1]]))
    return walk[::-1]
