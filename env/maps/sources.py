"""Where a scenario's maps come from: a generator, files, or the bundled office."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, Self, get_args

from pydantic import Field, PrivateAttr

from indoor_explorers.env.maps.base import BaseMaps
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.generators.cave import CaveMaps
from indoor_explorers.env.maps.generators.floors.plans import FloorsMaps
from indoor_explorers.env.maps.generators.maze import MazeMaps
from indoor_explorers.env.maps.generators.offices import OfficesMaps
from indoor_explorers.env.maps.generators.rooms import RoomsMaps
from indoor_explorers.env.maps.generators.thesis import ThesisMaps

__all__ = [
    "SOURCES",
    "CaveMaps",
    "FileMaps",
    "FloorsMaps",
    "MapSource",
    "MazeMaps",
    "OfficeMap",
    "OfficesMaps",
    "RoomsMaps",
    "ThesisMaps",
]


#: Stands for the path of a map file where it must not be known.
HIDDEN = "(not told)"


class FileMaps(BaseMaps):
    """Maps read from files of the kinds that :func:`~indoor_explorers.env.maps.files.read_map` knows."""

    source: Literal["files"] = "files"
    paths: tuple[str, ...] = Field(min_length=1)
    """Files, each explored with every seed."""
    resolution: float | None = Field(None, gt=0.0)
    """Metres a cell to resample to; None keeps the file's. Files without a scale count a pixel as one metre."""
    _held: dict[int, Floorplan] = PrivateAttr(default_factory=dict)

    @property
    def count(self) -> int:
        """One map for each file."""
        return len(self.paths)

    def floorplan(self, index: int, seed: int, attempt: int = 0) -> Floorplan:
        """Read file ``index``; the seed does not matter. Files of one name are told apart by their folders."""
        if index in self._held:
            return self._held[index]
        path = Path(self.paths[index])
        plan = _read_once(str(path), self.resolution)
        alike = sum(Path(other).stem == path.stem for other in self.paths) > 1
        return replace(plan, name=f"{path.parent.name}/{path.stem}") if alike else plan

    def holding(self, plans: Mapping[int, Floorplan]) -> FileMaps:
        """Return the same maps with some floor plans in memory, by index, for machines that cannot read their files."""
        held = self.model_copy()
        held._held = dict(plans)
        return held

    def without_files(self) -> Self:
        """Return as many maps whose files nobody can read."""
        return type(self)(paths=(HIDDEN,) * self.count, resolution=self.resolution)

    def identity(self) -> Any:
        """Return the digests of the maps' cells."""
        return {"source": self.source, "cells": [self.floorplan(index, 0).digest for index in range(self.count)]}


class OfficeMap(BaseMaps):
    """The bundled office floor."""

    source: Literal["office"] = "office"

    def floorplan(self, index: int, seed: int, attempt: int = 0) -> Floorplan:
        """Return the office; the seed does not matter."""
        return _office_once()

    def identity(self) -> Any:
        """Return the digest of the office's cells."""
        return {"source": self.source, "cells": [_office_once().digest]}


MapSource = ThesisMaps | RoomsMaps | OfficesMaps | FloorsMaps | CaveMaps | MazeMaps | FileMaps | OfficeMap

#: The kinds of maps by name.
SOURCES: dict[str, type[BaseMaps]] = {kind.model_fields["source"].default: kind for kind in get_args(MapSource)}


@lru_cache(maxsize=64)
def _read_once(path: str, resolution: float | None) -> Floorplan:
    from indoor_explorers.env.maps.files import read_map

    return read_map(path, resolution)


@lru_cache(maxsize=1)
def _office_once() -> Floorplan:
    from indoor_explorers.env.maps.readers.office import office

    return office()
