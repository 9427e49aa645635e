"""The kind of a floor plan and the statistics that tell it, from the cells alone.

The thresholds were chosen on maps whose kind is known by their source or by eye; ``evaluation/SUITES.md`` has the
confusion. Open plans of several rooms, warehouses and homes are no kinds of their own: the first have the
statistics of rooms and corridors, the second those of halls, and of the third there were too few to tell.
"""

from __future__ import annotations

import math
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.room_graph import CORRIDOR, PASSAGE, ROOM, local_widths, nodes_of, room_graph
from indoor_explorers.env.maps.statistics import FURNITURE, straight_share
from indoor_explorers.env.search.connected_parts import extent
from indoor_explorers.env.sensing.lidar import lidar_model, new_scan, visible_cells

#: The radius in cells of the disc of :attr:`PlanStatistics.openness`, and the farthest cell that counts as in view.
DISC, FARTHEST = 10, 256
#: Free cells, evenly spaced in the order of rows, that views are taken from.
VIEWS = 50
#: The width in metres from which on a passage is none of a door; three cells of half a metre are less.
WIDE = 2.0
#: Metres a cell from which on there is no scale: a pixel of a plain picture counts as one metre.
NO_SCALE = 1.0
#: Share of one width from which on passages are those of a maze.
ONE_WIDTH = 0.85
#: Effective number of parts from which on a floor is one of rooms.
SEVERAL_ROOMS = 2.75
#: In view of a free cell of a hall is this share of it, and it fills the first share of its convex hull; or, with
#: racks that hide the rest, the second.
IN_VIEW, COMPACT, VERY_COMPACT = 0.3, 0.68, 0.77


class Kind(StrEnum):
    """A kind of floor plan."""

    ROOMS = "rooms and corridors"
    """Several rooms and corridors behind doors."""
    HALL = "hall"
    """One wide room that is most of the floor, with or without columns, racks and side rooms."""
    MAZE = "maze"
    """Corridors of one width, and nothing else."""
    DUNGEON = "dungeon"
    """Irregular: rooms and wide passages without doors, or caves."""


class PlanStatistics(NamedTuple):
    """What is measured of the largest connected part of a floor; shares are of its free cells."""

    clearance: float
    """Mean distance of a free cell to the nearest solid one, in metres, in cells where there is no scale."""
    openness: float
    """Mean share of the disc of 10 cells around a free cell that is in view from it."""
    view: float
    """Mean share of the floor that is in view from a free cell: its isovist (Benedikt, To take hold of space, 1979)."""
    rooms: float
    """Effective number of rooms and corridors, the inverse of Simpson's index of their sizes (Nature 163, 1949)."""
    corridors: float
    """Share of corridors, parts at least four times as long as wide."""
    one_width: float
    """Share of the cells whose local width is the median one."""
    solidity: float
    """Share of the convex hull, small solid pieces counted as free."""
    straight: float
    """Share of the walls that run along the axes."""

    @property
    def kind(self) -> Kind:
        """The kind by the thresholds of this module."""
        if self.view >= IN_VIEW and self.solidity >= COMPACT:
            return Kind.HALL
        if self.rooms >= SEVERAL_ROOMS:
            return Kind.ROOMS
        if self.one_width >= ONE_WIDTH:
            return Kind.MAZE
        return Kind.HALL if self.solidity >= VERY_COMPACT else Kind.DUNGEON


def kind_of(plan: Floorplan) -> Kind:
    """Return the kind of a floor plan; equal cells and scales have equal kinds."""
    return statistics_of(plan).kind


def has_scale(plan: Floorplan) -> bool:
    """Return whether a cell of a floor plan is known in metres."""
    return plan.resolution is not None and plan.resolution < NO_SCALE


def statistics_of(plan: Floorplan) -> PlanStatistics:
    """Measure the largest connected free part of a floor plan; of several levels, their mean by free cells."""
    floors = plan.floors()
    found = [_measured(floor, plan.resolution if has_scale(plan) else None) for floor in floors]
    return PlanStatistics(*np.average(found, axis=0, weights=[floor.sum() for floor in floors]).tolist())


def _measured(floor: Mask, scale: float | None) -> PlanStatistics:
    """Measure the (H, W) cells of one level; ``scale`` is metres a cell, None for none."""
    from scipy import ndimage

    free = np.pad(floor[extent(floor)], 1)
    widths = local_widths(free)
    graph = room_graph(free, _passage(scale), widths)
    sizes, long = (
        np.array([graph.nodes[node]["cells"] for node in nodes_of(graph, *kinds)], np.float64)
        for kinds in ((ROOM, CORRIDOR), (CORRIDOR,))
    )
    openness, view = _views(free)
    return PlanStatistics(
        clearance=float(ndimage.distance_transform_edt(free)[free].mean()) * (scale or 1.0),
        openness=openness,
        view=view,
        rooms=float(sizes.sum() ** 2 / (sizes**2).sum()),
        corridors=float(long.sum() / sizes.sum()),
        one_width=float((widths[free] == np.floor(np.median(widths[free]))).mean()),
        solidity=_solidity(free),
        straight=straight_share(free),
    )


def _passage(scale: float | None) -> int:
    """Return the widest passage in cells that a door may be in; ``scale`` is metres a cell, None for none."""
    return max(1, math.ceil(WIDE / scale - 1e-9) - 1) if scale else PASSAGE


def _views(free: Mask) -> tuple[float, float]:
    """Return the mean shares of the disc and of the floor that are in view, (H, W) with solid cells around."""
    truth = np.where(free, FREE, OCCUPIED).astype(np.uint8)
    lidar = lidar_model(float(min(FARTHEST, int(np.hypot(*free.shape)))))
    work, cells = new_scan(lidar), np.argwhere(free)
    near = far = 0
    places = cells[:: max(1, len(cells) // VIEWS)]
    for row, col in places.tolist():
        listed = np.unique(work.cells[: visible_cells(truth, row, col, lidar, work)])
        seen = listed[truth.flat[listed] == FREE]
        rows, cols = np.divmod(seen, free.shape[1])
        near += int(((rows - row) ** 2 + (cols - col) ** 2 <= DISC**2).sum())
        far += len(seen)
    return near / len(places) / (lidar_model(float(DISC)).disc + 1), far / len(places) / len(cells)


def _solidity(free: Mask) -> float:
    from scipy import ndimage, spatial

    pieces, _ = ndimage.label(~free, np.ones((3, 3)))
    filled = free | (np.bincount(pieces.ravel()) <= FURNITURE)[pieces]
    rows = np.flatnonzero(filled.any(axis=1))
    first, last = filled[rows].argmax(axis=1), filled.shape[1] - filled[rows, ::-1].argmax(axis=1)
    corners = np.concatenate([np.stack([rows + low, col], axis=1) for low in (0, 1) for col in (first, last)])
    return float(filled.sum() / spatial.ConvexHull(corners).volume)  # in two dimensions the volume is the area
