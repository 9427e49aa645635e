"""Caves: noise smoothed by a cellular automaton, its parts joined by tunnels.

The automaton is that of Johnson, Yannakakis and Togelius, Cellular automata for real-time generation of infinite
cave levels (2010), doi 10.1145/1814256.1814266: a cell is solid when at least five of the 3 x 3 cells around it are.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.base import GeneratedMaps
from indoor_explorers.env.search.connected_parts import connected_parts, spanning_tree

#: A cave with a smaller free share than this is drawn again with less rock.
ENOUGH = 0.15
#: Decrease of the share of rock in each further try; without rock the cave is one open chamber.
EASING = 0.05


class CaveMaps(GeneratedMaps):
    """Random caves."""

    source: Literal["cave"] = "cave"
    rock: float = Field(0.45, ge=0.0, le=0.6)
    """Share of cells that are solid before smoothing; from about 0.5 on chambers come apart and tunnels join them."""
    smoothing: int = Field(5, ge=0, le=50)
    """Rounds of the automaton; each makes the walls rounder."""
    chamber: int = Field(20, ge=1)
    """Cells of the smallest chamber; smaller pockets become solid."""

    def draw(self, rng: np.random.Generator) -> Mask:
        """Return the (height, width) mask of the cave."""
        noise = rng.random((self.height, self.width))
        for rock in np.arange(self.rock, 0.0, -EASING).tolist():
            free = joined(self._smoothed(noise < rock), self.chamber)
            if free.mean() >= ENOUGH:
                return free
        return ~_closed(np.zeros_like(noise, np.bool_))

    def _smoothed(self, solid: Mask) -> Mask:
        """Run the automaton on a mask of solid cells, with solid rock around it; return the free cells."""
        solid = _closed(solid)
        for _ in range(self.smoothing):
            padded = np.pad(solid, 1, constant_values=True).astype(np.uint8)
            rows = padded[:-2] + padded[1:-1] + padded[2:]
            solid = _closed(rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:] >= 5)
        return ~solid


def _closed(solid: Mask) -> Mask:
    """Return a mask of solid cells with the border solid."""
    return np.pad(solid[1:-1, 1:-1], 1, constant_values=True)


def joined(free: Mask, least: int) -> Mask:
    """Return a (H, W) bool mask as one connected part, with the border solid.

    Parts of fewer than ``least`` cells become solid, unless they are the largest; the others are joined along a
    minimum spanning tree of the gaps between them by straight tunnels, two cells wide.
    """
    labels, sizes = connected_parts(free)
    sizes[0] = 0
    kept = sizes >= min(least, int(sizes.max(initial=0)))
    kept[0] = False
    labels = np.where(kept, np.cumsum(kept), 0).astype(np.int32)[labels]
    out = labels > 0
    if kept.sum() > 1:
        for one, other in _bridges(labels, int(kept.sum())):
            _carve(out, one, other)
    return out


def _bridges(labels: NDArray[np.int32], count: int) -> NDArray[np.int64]:
    """Return (count - 1, 2, 2) pairs of (row, column) cells of different parts, as near as can be.

    Every solid cell belongs to its nearest part; where the regions of two parts meet, the two cells' ways to their
    parts make a bridge.
    """
    from scipy import ndimage  # here, since it takes long to import

    distance, (rows, cols) = ndimage.distance_transform_edt(labels == 0, return_indices=True)
    region = labels[rows, cols]
    flat = np.arange(labels.size).reshape(labels.shape)
    ends = []
    for one, other in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        meet = region[one] != region[other]
        ends.append(np.stack([flat[one][meet], flat[other][meet]], axis=1))
    sides = np.concatenate(ends)
    parts = np.sort(region.ravel()[sides], axis=1)
    order = np.argsort(distance.ravel()[sides].sum(axis=1), kind="stable")
    _, first = np.unique(parts[order] @ np.array([count + 1, 1]), return_index=True)
    chosen = sides[order[np.sort(first[spanning_tree(parts[order[first]] - 1, first.astype(np.float64), count)])]]
    return np.stack([rows.ravel()[chosen], cols.ravel()[chosen]], axis=2).astype(np.int64)


def _carve(free: Mask, one: NDArray[np.int64], other: NDArray[np.int64]) -> None:
    """Free a straight strip between two cells, inside the border."""
    steps = 2 * int(np.abs(one - other).max()) + 1
    line = np.rint(np.linspace(one, other, steps)).astype(np.int64)
    rows, cols = line[:, 0], line[:, 1]
    below = np.minimum(rows + 1, free.shape[0] - 2)
    right = np.minimum(cols + 1, free.shape[1] - 2)
    free[rows, cols] = free[below, cols] = free[rows, right] = True
