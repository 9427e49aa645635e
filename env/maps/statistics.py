"""Geometry statistics of a floor plan, from its free cells alone: widths, rooms, doors, loops, furniture and walls."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.room_graph import (
    CORRIDOR,
    DOOR,
    PASSAGE,
    ROOM,
    local_widths,
    loops,
    nodes_of,
    room_graph,
)
from indoor_explorers.env.search.connected_parts import extent

#: Solid pieces of at most this many cells are furniture.
FURNITURE = 12
#: A wall is straight where at least this many cells of it are in line.
STRAIGHT = 5


class Statistic(NamedTuple):
    """The name and unit of a statistic, for tables and figures."""

    name: str
    unit: str
    logarithmic: bool
    """Whether values are compared by their ratios."""


STATISTICS = (
    Statistic("floor", "free cells", True),
    Statistic("free share", "free cells / cells of the rectangle around them", False),
    Statistic("width", "cells, at every free cell", True),
    Statistic("corridor width", "cells, of long parts", True),
    Statistic("door width", "cells, of passages", False),
    Statistic("room", "cells of other parts", True),
    Statistic("loops", "loops a part", False),
    Statistic("dead ends", "share of parts with one passage", False),
    Statistic("furniture", "cells of small solid pieces / floor", False),
    Statistic("straight walls", "share in straight lines", False),
)


def map_statistics(free: Mask, passage: int = PASSAGE) -> dict[str, NDArray[np.float64]]:
    """Return the values of each of :data:`STATISTICS` for a connected (H, W) floor; most have one value.

    ``passage`` is the width in cells up to which a place is narrow: 1.5 m in cells of 0.5 m.
    """
    inner = np.pad(free[extent(free)], 1)
    widths = local_widths(inner)
    graph = room_graph(inner, passage, widths)
    parts = nodes_of(graph, ROOM, CORRIDOR)
    doors = [graph.nodes[node]["width"] for node in nodes_of(graph, DOOR)]
    values = (
        [inner.sum()],
        [inner[1:-1, 1:-1].mean()],
        widths[inner],
        [graph.nodes[node]["width"] for node in nodes_of(graph, CORRIDOR)],
        [width for width in doors if width <= passage],
        [graph.nodes[node]["cells"] for node in nodes_of(graph, ROOM)],
        [loops(graph) / len(parts)],
        [sum(graph.degree[node] == 1 for node in parts) / len(parts)],
        [furniture_share(inner)],
        [straight_share(inner)],
    )
    return {kind.name: np.asarray(found, np.float64) for kind, found in zip(STATISTICS, values, strict=True)}


def furniture_share(free: Mask) -> float:
    """Return the cells of small solid pieces as a share of the floor with them, (H, W) with solid cells around."""
    from scipy import ndimage

    pieces, _ = ndimage.label(~free, np.ones((3, 3)))
    sizes = np.bincount(pieces.ravel())[1:]
    small = int(sizes[sizes <= FURNITURE].sum())
    return small / (small + int(free.sum()))


def straight_share(free: Mask) -> float:
    """Return the share of the sides of cells between floor and wall that lie in line with others."""
    straight = total = 0
    for grid in (free, free.T):
        sides = grid[:-1].astype(np.int8) - grid[1:]
        lines = np.pad(sides, [(0, 0), (1, 1)]).ravel()
        ends = np.flatnonzero(np.diff(lines))
        runs = np.diff(ends)[lines[ends[:-1] + 1] != 0]
        straight += int(runs[runs >= STRAIGHT].sum())
        total += int(runs.sum())
    return straight / max(total, 1)
