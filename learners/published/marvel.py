"""What MARVEL's network sees: the graph of J. Chiun, S. Zhang, Y. Wang, Y. Cao, G. Sartoretti, ICRA 2025.

arXiv:2502.20217. Written from the paper and from what the released code computes. Nodes are the free points of a
lattice around the start, 0.4 sensor ranges apart, with edges along clear lines to nodes at most two rows and columns
away. Features of a node: place relative to the UAV, frontier points in view, whether it is on the shortest way to the
nearest useful node, 1 for a teammate's node, -1 for the UAV's, and the direction with the most frontier points.

MARVEL's camera sees 120 degrees, and its network chooses a node and one of three headings there. Our lidar sees all
around: the headings are offered as to the camera, the node of the best pair is flown to, and a visited node counts as
seen in all directions.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.learners.attention.network import Array
from indoor_explorers.learners.published.checkpoint import Published, Sizes
from indoor_explorers.learners.published.lattice import Indices, Points, clear_lines, frontier_points, walk_to, walks
from indoor_explorers.learners.published.sighted import Directions, Observation, SightedNodes, resolution
from indoor_explorers.planners.toolbox.peers.clone import PublishedCode

_CODE = PublishedCode(
    url="https://github.com/marmotlab/MARVEL",
    commit="1e2e17d0802a3a774b42c7b228b90a809c576d1f",
    files={
        "utils/model.py": "39badd37cad16ebb54760ab0b2e0552a689fbbd875c08dfe91b0ab14b20aad79",
        "utils/node_manager.py": "dcd2ffe1793e430507e74381a26b473d4b7a4e71b1c3aa9b2e76fecd32880408",
        "utils/utils.py": "fe465604643ede9ee341b1baf93b98afcde263430a09fa4d74cead775dc17cbb",
        "utils/agent.py": "7c6b28fadccf3e0d4946107644c296778755c3fc9921ade3bcdbec3a27ff5769",
        "utils/quads.py": "05c6f9129ad0395d98e33231af2483bbf37b8590adeeb28cb40f84442da11bb0",
    },
)
BINS = 36
NETWORK = Published(_CODE, "load_model/MARVEL/checkpoint.pth", Sizes(inputs=6, heads=4, headings=BINS))
#: Metres: the sensor range, the range within which frontier points count, the side of the blocks that have one, and the
#: distance of nodes.
RANGE, UTILITY_RANGE, BLOCK, SPACING = 10.0, 9.0, 0.8, 4.0
#: Metres around the UAV within which nodes are added, are joined to others, and look for frontier points.
ADDED, JOINED, RENEWED = 28.0, 14.0, 20.0
#: Rows and columns to the furthest neighbour. A node with at most so many points is spent.
REACH, LEAST = 2, 1.0
#: Divisors of the features: metres, and frontier points.
METRES, POINTS = 112.0, 78.0
#: Headings offered at each node; bins to each side that the camera covers, and those that a heading without frontier
#: points covers before its own: the published code counts these in degrees.
HEADINGS, HALF_VIEW, BEFORE = 3, 6, 24
#: Half the side of the quadtree in distances of nodes; nodes of a leaf.
HALF, CAPACITY = 125.0, 4


class MarvelGraph:
    """The graph of one UAV in one episode, updated at each of its choices."""

    def __init__(self, shape: tuple[int, int], lidar_range: float) -> None:
        self._scale = resolution(lidar_range, RANGE, BLOCK)
        self._nodes = SightedNodes(shape, self._scale, UTILITY_RANGE * self._scale.cells)
        self._start: Cell | None = None
        self._places: dict[tuple[int, int], int] = {}  # columns and rows of the lattice from the start, to nodes
        self._joined: list[list[int]] = []  # the neighbours of each node, in the order in which they were found
        self._open: list[bool] = []  # whether a node still looks for neighbours
        self._visited: list[bool] = []

    def observe(
        self, belief: Belief, cell: Cell, mates: Sequence[Cell] = (), claimed: Sequence[Cell] = ()
    ) -> Observation:
        """Return what the network sees of a map (H, W) uint8 from a free cell, at which the UAV then has been.

        ``mates`` are the cells of the teammates, ``claimed`` the goals of those that choose before this UAV.
        """
        if self._start is None:
            self._start = cell
        else:
            own = self._nodes.nearest(cell)
            self._visited[own], self._open[own] = True, False
        self._grow(belief, cell)
        return self._observation(belief.shape[1], cell, mates, claimed)

    def _grow(self, belief: Belief, cell: Cell) -> None:
        """Add nodes around the UAV, and renew the points and the neighbours of those there."""
        nodes, width = self._nodes, belief.shape[1]
        frontiers = frontier_points(belief, 1)
        points = self._thinned(frontiers) @ (width, 1)
        around = self._around(belief, cell)
        known = np.array([self._places[place] for place in around if place in self._places], np.int64)
        active = np.zeros(len(nodes.cells), np.bool_)
        active[known] = np.hypot(*(nodes.cells[known] - cell).T) <= RENEWED * self._scale.cells
        active &= ~nodes.spent
        gone = np.setdiff1d(nodes.seen[1], frontiers @ (width, 1))
        nodes.renew(belief, gone, points, active, LEAST)
        for node in np.flatnonzero(active & nodes.spent):
            self._open[node] = False
        fresh = [place for place in around if place not in self._places]
        self._places |= {place: len(nodes.cells) + k for k, place in enumerate(fresh)}
        nodes.add(belief, self._cells_of(fresh), points, LEAST)
        self._joined += [[] for _ in fresh]
        self._open += [True for _ in fresh]
        self._visited += [False for _ in fresh]
        self._join(belief, cell, around)

    def _cells_of(self, places: Sequence[tuple[int, int]]) -> Points:
        """Return the (K, 2) cells of places on the lattice, columns and rows from the start; a cell apart at least."""
        step = max(1.0, SPACING * self._scale.cells)
        moves = np.round(np.array(places, np.float64).reshape(-1, 2)[:, ::-1] * step).astype(np.int64)
        return np.asarray(moves + np.array(self._start))

    def _around(self, belief: Belief, cell: Cell) -> list[tuple[int, int]]:
        """Return the places of the lattice in a window around a cell that are connected with it, column by column."""
        half = max(1, round(ADDED * self._scale.cells))
        low = np.maximum(np.array(cell) - half + 1, 1)
        high = np.minimum(np.array(cell) + half, np.array(belief.shape) - 1)
        low, high = np.minimum(low, cell), np.maximum(high, cell)
        parts, _ = label(belief[low[0] : high[0] + 1, low[1] : high[1] + 1] == FREE, np.ones((3, 3)))
        step, start = max(1.0, SPACING * self._scale.cells), np.array(self._start)
        first, last = np.floor((low - start) / step).astype(int), np.ceil((high - start) / step).astype(int)
        places = [(c, r) for c in range(first[1], last[1] + 1) for r in range(first[0], last[0] + 1)]
        cells = self._cells_of(places)
        inside = ((cells >= low) & (cells <= high)).all(axis=1)
        found = parts[tuple((np.clip(cells, low, high) - low).T)]
        joined = inside & (found == parts[tuple(np.array(cell) - low)]) & (found > 0)
        return [places[k] for k in np.flatnonzero(joined)]

    def _thinned(self, frontiers: Points) -> Points:
        """Return one of (P, 2) frontier cells in each block: that nearest to its corner, the leftmost of equals."""
        cells = frontiers[np.lexsort((frontiers[:, 0], frontiers[:, 1]))]
        block = self._scale.side / self._scale.cells
        metres = np.round((cells - np.array(self._start)) / self._scale.cells, 6)
        blocks = (metres / block).astype(np.int64)
        away = np.sqrt(np.square(metres - blocks * block).sum(axis=1))
        order = np.lexsort((np.arange(len(cells)), away, blocks[:, 1], blocks[:, 0]))
        _, first = np.unique(blocks[order], axis=0, return_index=True)
        return cells[order[first]]

    def _join(self, belief: Belief, cell: Cell, around: Sequence[tuple[int, int]]) -> None:
        """Join the open nodes near the UAV to those at most two rows and columns away with a clear line between."""
        nodes, offsets = self._nodes, range(-REACH, REACH + 1)
        close = np.hypot(*(nodes.cells - cell).T) < JOINED * self._scale.cells
        for place in around:
            node = self._places[place]
            if not (self._open[node] and close[node]):
                continue
            near = [self._places.get((place[0] + c, place[1] + r), -1) for c in offsets for r in offsets]
            near = [other for other in near if other not in (-1, node, *self._joined[node])]
            ends = nodes.cells[near]
            clear = clear_lines(belief, np.tile(nodes.cells[node], (len(near), 1)), ends)
            for other in np.array(near, np.int64)[clear].tolist():
                self._joined[node].append(other)
                self._joined[other].append(node)
            self._open[node] = not nodes.spent[node]

    def _observation(self, width: int, cell: Cell, mates: Sequence[Cell], claimed: Sequence[Cell]) -> Observation:
        nodes, utility = self._nodes, self._nodes.utility
        order = in_order(list(self._places))
        number = np.argsort(order)
        lists = [sorted([node, *self._joined[node]], key=number.__getitem__) for node in order]
        near = np.full((len(order), max(map(len, lists))), -1, np.int64)
        for row, each in zip(near, lists, strict=True):
            row[: len(each)] = number[each]
        own, cells = int(number[nodes.nearest(cell)]), nodes.cells[order]
        way = self._way(cells, near, own, utility[order] > 0)
        counts = self._counts(width)
        angles = np.where(utility > 0, _covered(counts).argmax(axis=1) * 10.0, -360.0)
        guidepost, occupied = np.zeros(len(cells)), np.zeros(len(cells))
        guidepost[way] = 1.0
        occupied[number[[nodes.nearest(mate) for mate in mates]].astype(int)] = 1.0
        occupied[own] = -1.0
        place = (cells - cells[own])[:, ::-1] / self._scale.cells / METRES
        shown = [place, utility[order] / POINTS, guidepost, occupied, angles[order] / 360.0]
        options = near[own][near[own] >= 0]
        taken = [int(number[nodes.nearest(goal)]) for goal in claimed]
        visited = np.repeat(np.array(self._visited, np.float32)[order, None], BINS, axis=1)
        headings = [self._headings(int(order[k]), order[way], counts, utility) for k in options]
        directions = Directions((counts[order] / (POINTS / BINS)).astype(np.float32), visited, np.stack(headings))
        legal = (options != own) & ~np.isin(options, taken)
        features = np.column_stack(shown).astype(np.float32)
        return Observation(cells, features, near, own, options, legal, utility[order] > 0, directions)

    def _way(self, cells: Points, near: Indices, own: int, useful: Mask) -> list[int]:
        """Return the nodes on the shortest walk to the nearest useful one; ``own`` alone if there is none."""
        length, before = walks(cells, near, own)
        length = np.where(useful & (length > 0), length, np.inf)
        end = int(length.argmin())
        return walk_to(before, end)[1:] if np.isfinite(length[end]) else [own]

    def _counts(self, width: int) -> NDArray[np.float64]:
        """Return the frontier points in view of each node by direction, (N, 36)."""
        node, point = self._nodes.seen
        away = np.stack(np.divmod(point, width), axis=1) - self._nodes.cells[node]
        counts = np.zeros((len(self._nodes.cells), BINS))
        np.add.at(counts, (node, _bins(away)), self._scale.weight)
        counts[self._nodes.spent] = 0.0
        return counts

    def _headings(self, node: int, way: Indices, counts: NDArray[np.float64], utility: NDArray[np.float64]) -> Array:
        """Return what the three headings offered at a node cover, (3, 36)."""
        covered = np.zeros((HEADINGS, BINS), np.float32)
        if utility[node] > 0:
            best = np.argsort(-_covered(counts[node : node + 1])[0], kind="stable")[:HEADINGS]
            span = np.arange(-HALF_VIEW, HALF_VIEW + 1)
            covered[np.arange(HEADINGS)[:, None], (best[:, None] + span) % BINS] = 1.0
            return covered
        cells = self._nodes.cells
        if len(way) > 1:
            faced = (int(_bins(cells[way[1]] - cells[node])) + np.arange(-1, 2)) % BINS
        else:
            faced = _bins(cells[self._joined[node][:HEADINGS]] - cells[node])
        for row, each in zip(covered, faced.tolist(), strict=False):
            row[max(0, each - BEFORE) :] = 1.0
        covered[len(faced) :, 1] = 1.0
        return covered


def _bins(moves: Points) -> Indices:
    """Return the bins of the directions of (..., 2) rows and columns."""
    angles = np.degrees(np.arctan2(moves[..., 0], moves[..., 1]) % (2 * np.pi))
    return (angles / 360 * BINS).astype(np.int64) % BINS


def _covered(counts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points within the camera's view for each heading, (N, 36), of (N, 36) points by direction."""
    return np.asarray(sum(np.roll(counts, shift, axis=1) for shift in range(-HALF_VIEW, HALF_VIEW + 1)))


def in_order(places: Sequence[tuple[int, int]]) -> NDArray[np.int64]:
    """Return the order (N,) in which nodes are listed, of (x, y) places on the lattice in the order of insertion.

    The network convolves over the nodes, so that its outputs depend on their order. The published code keeps them in a
    quadtree (Finkel and Bentley 1974) over 1,000 m around the start, and lists them leaf by leaf: upper left, upper
    right, lower left, lower right; in a leaf, in their order of insertion.
    """
    half, furthest = HALF, max((max(map(abs, place)) for place in places), default=0)
    while half < furthest:
        half *= 2
    points = np.array(places, np.float64).reshape(-1, 2)
    return _listed(points, np.arange(len(points)), np.zeros(2), half)


def _listed(
    points: NDArray[np.float64], nodes: NDArray[np.int64], centre: NDArray[np.float64], half: float
) -> NDArray[np.int64]:
    """Return the nodes of a square, leaf by leaf."""
    if len(nodes) <= CAPACITY:
        return nodes
    right, below = (points[nodes] >= centre)[:, 0], (points[nodes] < centre)[:, 1]
    quarters = [(-1, 1), (1, 1), (-1, -1), (1, -1)]
    parts = [nodes[(right == (x > 0)) & (below == (y < 0))] for x, y in quarters]
    middles = [centre + np.array(quarter) * (half / 2) for quarter in quarters]
    return np.concatenate(
        [_listed(points, part, middle, half / 2) for part, middle in zip(parts, middles, strict=True)]
    )
