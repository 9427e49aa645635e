"""The graph of rooms and doors of a floor plan, from its free cells alone.

A floor is cut into parts at its narrow places: free cells that no free square of more than ``passage`` cells a side
covers. A narrow place that touches two parts or more is a passage, as a door is; one that touches one part belongs to
it. A long one is a part of its own, as a narrow corridor is, unless it is open to another part over more than a
passage's width. Squares are the openings of granulometry (Matheron, Random Sets and Integral Geometry, 1975).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask

if TYPE_CHECKING:
    import networkx as nx

#: Widths are measured up to this many cells.
WIDEST = 64
#: The width in metres up to which a place is narrow, and the same in cells where a map has no scale.
PASSAGE_METRES, PASSAGE = 1.5, 3
#: Narrow places of at least this many cells for each cell of a passage's width are long.
LONG = 4
#: A part is a corridor when it has at least this many times the cells of a square of its width.
SLENDER = 4.0
#: The kinds of nodes.
ROOM, CORRIDOR, DOOR = "room", "corridor", "door"

Labels = NDArray[np.integer[Any]]


def passage_of(resolution: float | None) -> int:
    """Return the width in cells up to which a place is narrow; ``resolution`` is metres a cell, None for no scale."""
    return max(1, round(PASSAGE_METRES / resolution)) if resolution else PASSAGE


def room_graph(free: Mask, passage: int = PASSAGE, widths: NDArray[np.int64] | None = None) -> nx.Graph:
    """Return the graph of rooms, corridors and doors of an (H, W) floor; solid cells must surround it.

    Nodes are parts of the floor and the passages between them, with attributes ``kind`` (:data:`ROOM`,
    :data:`CORRIDOR` or :data:`DOOR`), ``width`` in cells (of a part, the median over its cells) and ``place``, a cell
    (row, column) in its middle; parts also have ``cells``, their number of free cells. An edge joins a passage to a
    part that it opens into. Openings where two parts meet are passages too, of any width.

    Args:
        free: True for free cells.
        passage: the width in cells up to which a place is narrow.
        widths: (H, W) what :func:`local_widths` returns for the floor, where it is known.

    """
    import networkx as nx  # here, since it takes long to import

    widths = local_widths(free) if widths is None else widths
    labels, doors, ends = _cut(free, widths, passage)
    graph = nx.Graph()
    for label, (rows, cols) in enumerate(_cells_of(labels), 1):
        wide = int(np.median(widths[rows, cols]))
        kind = CORRIDOR if len(rows) >= SLENDER * wide**2 else ROOM
        graph.add_node(label, kind=kind, cells=len(rows), width=wide, place=_middle(rows, cols))
    parts = len(graph)
    for place, (wide, (rows, cols)) in enumerate(doors):
        graph.add_node(parts + 1 + place, kind=DOOR, width=wide, place=_middle(rows, cols))
    graph.add_edges_from((parts + 1 + place, label) for place, label in ends.tolist())
    return graph


def nodes_of(graph: nx.Graph, *kinds: str) -> list[int]:
    """Return the nodes of some kinds."""
    return [node for node, kind in graph.nodes(data="kind") if kind in kinds]


def loops(graph: nx.Graph) -> int:
    """Return how many passages can be closed with everything still connected: the cycle rank of the graph."""
    import networkx as nx

    return int(graph.number_of_edges() - graph.number_of_nodes() + nx.number_connected_components(graph))


def doors_across(graph: nx.Graph) -> int:
    """Return how many passages are on the shortest way between the two parts that are farthest apart in passages."""
    import networkx as nx

    parts = {*nodes_of(graph, ROOM, CORRIDOR)}
    lengths = nx.all_pairs_shortest_path_length(graph)
    return max((length for node, reached in lengths if node in parts for length in reached.values()), default=0) // 2


def local_widths(free: Mask) -> NDArray[np.int64]:
    """Return (H, W): the side in cells of the largest free square that covers each free cell, 0 for solid cells."""
    from scipy import ndimage  # here, since it takes long to import

    widths = free.astype(np.int64)
    square = free.copy()  # True where the square of ``side`` cells that ends here, downwards and to the right, is free
    for side in range(2, WIDEST + 1):
        smaller, square = square, np.zeros_like(square)
        square[1:, 1:] = smaller[1:, 1:] & smaller[:-1, 1:] & smaller[1:, :-1] & smaller[:-1, :-1]
        if not square.any():
            break
        covered = square.astype(np.uint8)
        for axis in (0, 1):
            covered = ndimage.maximum_filter1d(covered, side, axis, mode="constant", origin=-(side // 2))
        widths[covered > 0] = side
    return widths


Cells = tuple[NDArray[np.int64], NDArray[np.int64]]


def _cut(free: Mask, widths: Labels, passage: int) -> tuple[Labels, list[tuple[int, Cells]], NDArray[np.int64]]:
    """Cut a (H, W) floor with these :func:`local_widths` where it is at most ``passage`` cells wide.

    Returns the part of each cell from 1 on, (H, W); the width and the cells of each passage; and (k, 2) pairs of a
    passage, from 0 on, and a part that it touches.
    """
    from scipy import ndimage

    rooms, count = ndimage.label(free & (widths > passage))
    narrow, narrows = ndimage.label(free & (widths <= passage))
    touching = _touching(narrow, rooms)
    touched = np.bincount(touching[:, 0], minlength=narrows + 1)
    long = (np.bincount(narrow.ravel(), minlength=narrows + 1) >= LONG * passage) | (touched == 0)
    long[0] = False
    owner = np.zeros(narrows + 1, np.int64)  # the part that each narrow place is or belongs to; 0 for a passage
    niches = touching[(touched == 1)[touching[:, 0]]]
    owner[niches[:, 0]] = niches[:, 1]
    mouth_of = _mouth_labels(np.where(long[narrow], narrow, 0), rooms)
    mouths = _mouths(mouth_of, narrow, rooms)
    owner[long] = 0
    for _, place, room, _ in mouths[mouths[:, 3] > passage]:
        owner[place] = room
    corridors = np.flatnonzero(long & (owner == 0))
    owner[corridors] = count + 1 + np.arange(len(corridors))
    doors = np.flatnonzero(~long & (touched > 1))
    through = touching[np.isin(touching[:, 0], doors)]
    mouths = mouths[owner[mouths[:, 1]] != mouths[:, 2]]
    places = len(doors) + np.arange(len(mouths))
    ends = [
        np.stack([np.searchsorted(doors, through[:, 0]), through[:, 1]], axis=1),
        np.stack([places, owner[mouths[:, 1]]], axis=1),
        np.stack([places, mouths[:, 2]], axis=1),
    ]
    places_of, mouth_cells = _cells_of(narrow), _cells_of(mouth_of)
    passages = [(int(widths[cells].max()), cells) for cells in (places_of[door - 1] for door in doors)]
    passages += [(int(size), mouth_cells[label - 1]) for label, _, _, size in mouths]
    return np.where(rooms > 0, rooms, owner[narrow]), passages, np.concatenate(ends)


def _cells_of(labels: Labels) -> list[Cells]:
    """Return the rows and columns of the cells of each label from 1 on."""
    from scipy import ndimage

    boxes = ndimage.find_objects(labels)
    found = [(box, np.nonzero(labels[box] == label)) for label, box in enumerate(boxes, 1)]
    return [(rows + box[0].start, cols + box[1].start) for box, (rows, cols) in found]


def _middle(rows: NDArray[np.int64], cols: NDArray[np.int64]) -> tuple[int, int]:
    """Return the cell nearest to the mean of some cells."""
    nearest = int(np.argmin((rows - rows.mean()) ** 2 + (cols - cols.mean()) ** 2))
    return int(rows[nearest]), int(cols[nearest])


def _touching(one: Labels, other: Labels) -> NDArray[np.int64]:
    """Return the (n, 2) pairs of labels above 0 of two maps whose cells are 4-neighbours somewhere."""
    found = []
    for first, second in ((one, other), (one.T, other.T)):
        for here, there in ((first[:-1], second[1:]), (first[1:], second[:-1])):
            meet = (here > 0) & (there > 0)
            found.append(np.stack([here[meet], there[meet]], axis=1))
    return np.unique(np.concatenate(found), axis=0).astype(np.int64)


def _mouth_labels(long: Labels, rooms: Labels) -> Labels:
    """Return (H, W) labels of the cells of long narrow places beside rooms, one for each place of meeting."""
    from scipy import ndimage

    beside, labels, count = ndimage.binary_dilation(rooms > 0), np.zeros_like(long), 0
    for place, box in enumerate(ndimage.find_objects(long), 1):
        if box is not None:
            found, here = ndimage.label(beside[box] & (long[box] == place), np.ones((3, 3)))
            labels[box] += np.where(found > 0, found + count, 0)
            count += here
    return labels


def _mouths(mouths: Labels, narrow: Labels, rooms: Labels) -> NDArray[np.int64]:
    """Return (n, 4): the label of a mouth, its narrow place, a room that it meets, and over how many cells."""
    pairs = _touching(mouths, rooms)
    place = np.zeros(int(mouths.max(initial=0)) + 1, np.int64)
    np.maximum.at(place, mouths.ravel(), np.where(mouths > 0, narrow, 0).ravel())
    sizes = np.bincount(mouths.ravel())
    return np.stack([pairs[:, 0], place[pairs[:, 0]], pairs[:, 1], sizes[pairs[:, 0]]], axis=1)
