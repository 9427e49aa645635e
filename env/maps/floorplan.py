"""The ground-truth occupancy grid of an episode, hidden from policies."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.grid.levels import Levels, plane_of
from indoor_explorers.env.maps.layouts import layout_digest
from indoor_explorers.env.search.connected_parts import largest_part

#: The most cells a map may have (2048 x 2048).
MAX_CELLS = 2048 * 2048


@dataclass(frozen=True, eq=False)
class Floorplan:
    """Hold a true map and its facts."""

    truth: Belief
    """(H, W) uint8: 1 free, 2 occupied; read-only."""
    name: str
    resolution: float | None = None
    """Metres a cell, None when the source does not say."""
    kept: float = 1.0
    """Share of the source's free area that can be reached in this map; 1.0 means that no floor was lost."""
    start: Cell | None = None
    """The free cell (row, column) that the source marks as the place to start from, if any."""
    connected: float = 1.0
    """Share of the source's free area that is in its largest connected part, before the source was reduced."""
    notes: tuple[str, ...] = ()
    """Warnings of the reader of the file, a line each."""
    level_count: int = 1
    """Levels of the map; with several, ``truth`` is the plane of them (:mod:`indoor_explorers.env.grid.levels`)."""
    added: int = 0
    """How many of them, on top, are solid and not in the source: for a scenario whose other maps have more levels."""

    def __post_init__(self) -> None:
        if self.truth.ndim != 2 or self.truth.size == 0:
            raise InputError(
                f"{self.name}: expected a map of at least one cell, got an array of shape {self.truth.shape}"
            )
        if self.truth.size > MAX_CELLS:
            raise InputError(
                f"{self.name}: expected at most {MAX_CELLS} cells, got {self.truth.shape[0]} x {self.truth.shape[1]}; "
                "ask for a coarser --resolution"
            )
        if not (self.truth == FREE).any():
            raise InputError(
                f"{self.name}: expected some free cells, got none; check the thresholds, or negate, of the map"
            )
        if self.start is not None and not self._is_free(self.start):
            raise InputError(f"{self.name}: expected the start on a free cell, got {self.start}; move the mark")
        self.truth.setflags(write=False)

    def __reduce__(self) -> tuple[Any, ...]:
        facts = self.truth, self.name, self.resolution, self.kept, self.start, self.connected, self.notes
        return Floorplan, (*facts, self.level_count, self.added)  # makes truth read-only again

    def _is_free(self, cell: Cell) -> bool:
        inside = all(0 <= place < side for place, side in zip(cell, self.shape, strict=True))
        return inside and bool(self.truth[cell] == FREE)

    @property
    def shape(self) -> tuple[int, int]:
        """(H, W) in cells."""
        return self.truth.shape[0], self.truth.shape[1]

    @property
    def levels(self) -> Levels:
        """What is where in a map of several levels."""
        return Levels.of(self.shape, self.level_count)

    @cached_property
    def digest(self) -> str:
        """A short hash of shape, cells and start, if any: equal maps from different files have equal digests.

        Levels that were :attr:`added` do not count.
        """
        mark = b"" if self.start is None else repr(self.start).encode()
        own = self.levels._replace(number=self.level_count - self.added)
        cells = self.truth[: own.shape[0]].tobytes()
        return hashlib.sha256(repr(own.size).encode() + cells + mark).hexdigest()[:16]

    @cached_property
    def layout(self) -> str:
        """A short hash of the free cells, the same for turned, mirrored, cropped and rescaled maps."""
        return layout_digest(self.truth == FREE)

    @cached_property
    def main_part(self) -> Mask:
        """(H, W) mask of the largest connected free part, where UAVs are spawned; read-only."""
        free = self.truth == FREE
        several = self.level_count > 1
        part = plane_of(largest_part(self.levels.volume(free)), False) if several else largest_part(free)
        part.setflags(write=False)
        return part

    def raised(self, count: int) -> Floorplan:
        """Return the map with solid levels on top until it has ``count`` levels; itself if it has as many."""
        if count <= self.level_count:
            return self
        rows = self.levels._replace(number=count).shape[0] - self.shape[0]
        truth = np.pad(self.truth, ((0, rows), (0, 0)), constant_values=OCCUPIED)
        return replace(self, truth=truth, level_count=count, added=self.added + count - self.level_count)

    def floors(self) -> list[Mask]:
        """Return the (H, W) mask of the main part on each level that has some of it, the lowest first."""
        return [floor for floor in self.levels.volume(self.main_part) if floor.any()]

    @classmethod
    def from_free(
        cls, free: Mask, name: str, resolution: float | None = None, kept: float = 1.0, start: Cell | None = None
    ) -> Floorplan:
        """Build a floor plan from a bool mask of its free cells, (H, W) or, with several levels, (L, H, W)."""
        if free.ndim > 2 and len(free) > 1:
            plane = plane_of(np.where(free, FREE, OCCUPIED), OCCUPIED)
            return cls(plane, name, resolution, kept, start, level_count=len(free))
        free = free.reshape(free.shape[-2:])
        return cls(np.where(free, FREE, OCCUPIED).astype(np.uint8), name, resolution, kept, start)
