"""The graph of viewpoints in the known free space around one UAV (the informative graph of ARiADNE 2023).

The papers spread nodes evenly on a lattice and join nodes by collision-free straight lines. In our maps, doors are one
cell wide, so a lattice would miss them. Here the map is cut into square blocks, and each connected part of a block's
free cells has one node: its cell nearest to the centre of the block. Node 0 is the UAV's own cell. Edges lead to the
nodes with the shortest paths through free cells. So the graph is connected where the free space is, and every edge can
be flown.

Features of a node, as in the papers: position relative to the UAV; utility, the number of frontier cells in view; and a
guidepost. The released code of both papers marks visited nodes by the guidepost, and takes their utility away; here it
marks the nodes near a shortest path to the nearest useful one. A node is useful if unknown cells are in view and the
UAV has not been there. Beyond the papers: unknown cells in view, steps from the UAV, and for teams the closeness of
teammates and of their goals. Lengths are in lidar ranges, so that one network fits every lidar.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from indoor_explorers.env.grid.arrays import Belief, Cell, Distances, Mask
from indoor_explorers.env.grid.cells import FREE, MOVES, UNKNOWN, UNREACHABLE
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.search.bfs import distance_field
from indoor_explorers.env.search.frontiers import frontier_mask
from indoor_explorers.env.sensing.lidar import LidarModel, lidar_model, new_scan, visible_cells
from indoor_explorers.learners.sessions.settings import Settings

#: Features of a node of the known map, and of the true map.
FEATURES, TRUE_FEATURES = 11, 13
#: Columns of the features that are used elsewhere.
UTILITY, USEFUL, GUIDEPOST = 2, 3, 4
#: Range within which frontier cells count for the utility, in lidar ranges; the released code has 70 of 80 pixels.
UTILITY_RANGE = 0.8
#: What the cells of an area are: no place for a node, known and free, free and not known yet.
_SHUT, _KNOWN, _HIDDEN = 0, 1, 2
#: Scales of features: positions and steps in lidar ranges, logarithms of counts.
_POSITION, _STEPS, _FRONTIERS, _CELLS = 3.0, 5.0, 3.0, 5.0


class GraphSettings(Settings):
    """How graphs are made."""

    spacing: float = Field(0.4, gt=0.0, le=2.0)
    """Side of a block in lidar ranges; at least two cells."""
    neighbours: int = Field(8, ge=1, le=64)
    """Edges of each node."""

    def side(self, lidar_range: float) -> int:
        """Return the side of a block in cells for a lidar range in cells."""
        return max(2, round(self.spacing * lidar_range))


class Graph(NamedTuple):
    """N nodes; node 0 is the UAV's cell."""

    cells: NDArray[np.int32]
    """(N,) flat cells."""
    features: NDArray[np.float32]
    """(N, FEATURES), or (N, TRUE_FEATURES) for the true map."""
    neighbours: NDArray[np.int32]
    """(N, K) nodes, nearest first, -1 where there are fewer."""


class Surroundings(NamedTuple):
    """What a graph is made from, besides the map."""

    lidar_range: float
    """Cells."""
    visited: Mask
    """(H, W) bool, cells that the UAV has been in."""
    mates: tuple[Cell, ...] = ()
    """Last known cells of the teammates to consider."""
    goals: tuple[tuple[float, float], ...] = ()
    """Their goals, as far as they are known."""


@leaf(entry=False)
def _flood_block(
    area: np.ndarray, seed: int, box: tuple[int, int, int, int], done: np.ndarray, queue: np.ndarray
) -> int:
    """Fill ``queue`` with the part of a block, rows and columns of ``box``, around a flat cell; return its size."""
    width, kind = area.shape[1], area.flat[seed]
    queue[0], done[seed] = seed, True
    head, tail = 0, 1
    while head < tail:
        row, col = divmod(queue[head], width)
        head += 1
        for k in range(4):
            r, c = row + MOVES[k, 0], col + MOVES[k, 1]
            inside = box[0] <= r < box[1] and box[2] <= c < box[3]
            if inside and area[r, c] == kind and not done[r * width + c]:
                done[r * width + c] = True
                queue[tail] = r * width + c
                tail += 1
    return tail


@leaf(entry=False)
def _central(cells: np.ndarray, middle: tuple[float, float], width: int) -> int:
    """Return the cell of (K,) that is nearest to ``middle``."""
    best, least = cells[0], np.inf
    for k in range(cells.shape[0]):
        row, col = divmod(cells[k], width)
        away = (row - middle[0]) ** 2 + (col - middle[1]) ** 2
        if away < least:
            best, least = cells[k], away
    return int(best)


@kernel()
def _nodes(area: np.ndarray, own: int, side: int) -> np.ndarray:
    """Return the flat cells of the nodes: ``own`` first, then those in known cells, then those in hidden ones."""
    height, width = area.shape
    nodes, count = np.empty(area.size, np.int32), 1
    nodes[0] = own
    done, queue = np.zeros(area.size, np.bool_), np.empty(side * side, np.int32)
    for kind in (_KNOWN, _HIDDEN):
        for top in range(0, height, side):
            for left in range(0, width, side):
                box = (top, min(top + side, height), left, min(left + side, width))
                middle = ((box[0] + box[1] - 1) / 2, (box[2] + box[3] - 1) / 2)
                for row in range(box[0], box[1]):
                    for col in range(box[2], box[3]):
                        seed = row * width + col
                        if area[row, col] == kind and not done[seed]:
                            size = _flood_block(area, seed, box, done, queue)
                            cell = _central(queue[:size], middle, width)
                            if cell != own and (kind == _KNOWN or size >= side):  # scraps of hidden cells have none
                                nodes[count] = cell
                                count += 1
    return nodes[:count].copy()


@kernel()
def _edges(area: np.ndarray, nodes: np.ndarray, most: int) -> np.ndarray:
    """Return the ``most`` nodes with the shortest paths from each of (N,) nodes, (N, most), by breadth-first search."""
    height, width = area.shape
    number, mark = np.full(area.size, -1, np.int32), np.full(area.size, -1, np.int32)
    queue, out = np.empty(area.size, np.int32), np.full((nodes.shape[0], most), -1, np.int32)
    for n in range(nodes.shape[0]):
        number[nodes[n]] = n
    for n in range(nodes.shape[0]):
        queue[0], mark[nodes[n]] = nodes[n], n
        head, tail, found = 0, 1, 0
        while head < tail and found < most:
            row, col = divmod(queue[head], width)
            head += 1
            for k in range(4):
                r, c = row + MOVES[k, 0], col + MOVES[k, 1]
                cell = r * width + c
                if 0 <= r < height and 0 <= c < width and area[r, c] != _SHUT and mark[cell] != n:
                    mark[cell], queue[tail] = n, cell
                    tail += 1
                    if number[cell] >= 0 and found < most:
                        out[n, found] = number[cell]
                        found += 1
    return out


@kernel()
def _in_view(occupancy: np.ndarray, nodes: np.ndarray, counted: np.ndarray, lidar: LidarModel) -> np.ndarray:
    """Return how many cells of ``counted`` (H, W) bool are seen from each of (N,) flat cells, (N,)."""
    width, scan, wanted = occupancy.shape[1], new_scan(lidar), counted.ravel()
    out = np.zeros(nodes.shape[0], np.int32)
    for n in range(nodes.shape[0]):
        for place in range(visible_cells(occupancy, nodes[n] // width, nodes[n] % width, lidar, scan)):
            out[n] += wanted[scan.cells[place]]
    return out


def unknown_in_view(belief: Belief, nodes: NDArray[np.int32], lidar_range: float) -> NDArray[np.int32]:
    """Return how many unknown cells are in view of each of (N,) flat cells, (N,)."""
    return np.asarray(_in_view(belief, nodes, belief == UNKNOWN, lidar_model(lidar_range)))


def known_graph(belief: Belief, cell: Cell, steps: Distances, around: Surroundings, settings: GraphSettings) -> Graph:
    """Return the graph of a known map (H, W) uint8 for a UAV at ``cell``; ``steps`` (H, W) are those from there."""
    area = np.where((belief == FREE) & (steps < UNREACHABLE), _KNOWN, _SHUT).astype(np.uint8)
    area[cell] = _KNOWN
    return _graph(area, belief, cell, steps, around, settings)


def true_graph(
    belief: Belief, truth: Belief, cell: Cell, steps: Distances, around: Surroundings, settings: GraphSettings
) -> Graph:
    """Return the graph of the true map, for the privileged critic (the ground truth graph of RA-L 2024).

    Its first nodes are those of :func:`known_graph`; then come those in free cells that the UAV cannot reach or does
    not know yet. Two more features tell these nodes, and how many unknown free cells are truly in view of each node.
    """
    reachable = distance_field(truth, cell) < UNREACHABLE
    known = (belief == FREE) & (steps < UNREACHABLE)
    area = np.where(known, _KNOWN, np.where((truth == FREE) & reachable, _HIDDEN, _SHUT)).astype(np.uint8)
    area[cell] = _KNOWN
    graph = _graph(area, belief, cell, steps, around, settings)
    left = (belief == UNKNOWN) & (truth == FREE)
    seen = _in_view(truth, graph.cells, left, lidar_model(around.lidar_range))
    extra = np.column_stack([area.ravel()[graph.cells] == _HIDDEN, np.log1p(seen) / _CELLS])
    return graph._replace(features=np.concatenate([graph.features, extra.astype(np.float32)], axis=1))


def _graph(
    area: NDArray[np.uint8],
    belief: Belief,
    cell: Cell,
    steps: Distances,
    around: Surroundings,
    settings: GraphSettings,
) -> Graph:
    width, reach = belief.shape[1], around.lidar_range
    nodes = _nodes(area, cell[0] * width + cell[1], settings.side(reach))
    known = area.ravel()[nodes] == _KNOWN
    unknown = unknown_in_view(belief, nodes, reach) * (known & ~around.visited.ravel()[nodes])
    frontiers = _in_view(belief, nodes, frontier_mask(belief), lidar_model(UTILITY_RANGE * reach)) * known
    rows, cols = np.divmod(nodes, width)
    away = np.minimum(steps.ravel()[nodes] / reach, 4.0 * _STEPS)
    columns = [
        np.clip((rows - cell[0]) / reach / _POSITION, -4.0, 4.0),
        np.clip((cols - cell[1]) / reach / _POSITION, -4.0, 4.0),
        np.log1p(frontiers) / _FRONTIERS,
        unknown > 0,
        _guideposts(belief, nodes, steps, unknown, settings.side(reach)),
        np.arange(len(nodes)) == 0,
        np.log1p(unknown) / _CELLS,
        away / _STEPS,
        *_of_teammates(belief, nodes, away, around),
    ]
    return Graph(nodes, np.column_stack(columns).astype(np.float32), _edges(area, nodes, settings.neighbours))


def _guideposts(
    belief: Belief, nodes: NDArray[np.int32], steps: Distances, unknown: NDArray[np.int32], side: int
) -> NDArray[np.bool_]:
    """Return which of (N,) nodes are near a shortest path to the nearest other one with ``unknown`` cells in view."""
    own = steps.ravel()[nodes]
    useful = np.flatnonzero(unknown[1:]) + 1
    if not len(useful):
        return np.zeros(len(nodes), np.bool_)
    target = useful[own[useful].argmin()]
    back = distance_field(belief, divmod(int(nodes[target]), belief.shape[1])).ravel()[nodes]
    return np.asarray((own < UNREACHABLE) & (own + back.astype(np.int64) <= own[target] + side // 2))


def _of_teammates(
    belief: Belief, nodes: NDArray[np.int32], away: NDArray[np.float64], around: Surroundings
) -> list[NDArray[np.float64]]:
    """Return how close teammates and their goals are to (N,) nodes, and whether a teammate is closer than the UAV."""
    mates, goals = np.full(len(nodes), np.inf), np.full(len(nodes), np.inf)
    for mate in around.mates:
        mates = np.minimum(mates, distance_field(belief, mate).ravel()[nodes] / around.lidar_range)
    rows, cols = np.divmod(nodes, belief.shape[1])
    for row, col in around.goals:
        goals = np.minimum(goals, np.hypot(rows - row, cols - col) / around.lidar_range)
    return [np.exp(-mates), np.exp(-2.0 * goals), (mates < away).astype(np.float64)]
