"""Where a scenario's maps come from: a generator, files, or the bundled office."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, model_validator

from indoor_explorers.env.maps.base import BaseMaps as _Source
from indoor_explorers.env.maps.cave import CaveMaps
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.maze import MazeMaps
from indoor_explorers.env.maps.offices import OfficesMaps
from indoor_explorers.env.maps.rooms import RoomsMaps
from indoor_explorers.env.maps.thesis import thesis_room
from indoor_explorers.env.randomness import Stream, generator

__all__ = ["CaveMaps", "FileMaps", "MapSource", "MazeMaps", "OfficeMap", "OfficesMaps", "RoomsMaps", "ThesisMaps"]


class ThesisMaps(_Source):
    """Random rooms as in the thesis."""

    source: Literal["thesis"] = "thesis"
    height: int = Field(16, ge=2, le=2048)
    """Cells."""
    width: int = Field(16, ge=2, le=2048)
    """Cells."""
    obstacles: int = Field(5, ge=0, le=100_000)
    """Rectangles thrown in; they may overlap."""
    obstacle_size: tuple[int, int] = (3, 3)
    """Smallest and largest side of a rectangle in cells."""
    margin: int = Field(1, ge=0)
    """Cells kept free between the border and a rectangle's upper left cell."""

    @model_validator(mode="after")
    def _consistent(self) -> ThesisMaps:
        smallest, largest = self.obstacle_size
        if not 1 <= smallest <= largest:
            raise ValueError(f"obstacle_size is {[smallest, largest]}, expected 1 <= smallest <= largest")
        return self

    @property
    def generated(self) -> bool:
        """True: every seed has a room of its own."""
        return True

    def floorplan(self, index: int, seed: int, attempt: int = 0) -> Floorplan:
        """Draw the room of an episode seed."""
        return thesis_room(
            generator(seed, Stream.MAP, attempt),
            height=self.height,
            width=self.width,
            obstacles=self.obstacles,
            obstacle_size=self.obstacle_size,
            margin=self.margin,
        )


class FileMaps(_Source):
    """Maps read from files of the kinds that :func:`~indoor_explorers.env.maps.files.read_map` knows."""

    source: Literal["files"] = "files"
    paths: tuple[str, ...] = Field(min_length=1)
    """Files, each explored with every seed."""
    resolution: float | None = Field(None, gt=0.0)
    """Metres a cell to resample to; None keeps the file's. Files without a scale count a pixel as one metre."""

    @property
    def count(self) -> int:
        """One map for each file."""
        return len(self.paths)

    def floorplan(self, index: int, seed: int, attempt: int = 0) -> Floorplan:
        """Read file ``index``; the seed does not matter. Files of one name are told apart by their folders."""
        path = Path(self.paths[index])
        plan = _read_once(str(path), self.resolution)
        alike = sum(Path(other).stem == path.stem for other in self.paths) > 1
        return replace(plan, name=f"{path.parent.name}/{path.stem}") if alike else plan

    def identity(self) -> Any:
        """Return the digests of the maps' cells."""
        return {"source": self.source, "cells": [self.floorplan(index, 0).digest for index in range(self.count)]}


class OfficeMap(_Source):
    """The bundled office floor."""

    source: Literal["office"] = "office"

    def floorplan(self, index: int, seed: int, attempt: int = 0) -> Floorplan:
        """Return the office; the seed does not matter."""
        return _office_once()

    def identity(self) -> Any:
        """Return the digest of the office's cells."""
        return {"source": self.source, "cells": [_office_once().digest]}


MapSource = ThesisMaps | RoomsMaps | OfficesMaps | CaveMaps | MazeMaps | FileMaps | OfficeMap


@lru_cache(maxsize=64)
def _read_once(path: str, resolution: float | None) -> Floorplan:
    from indoor_explorers.env.maps.files import read_map

    return read_map(path, resolution)


@lru_cache(maxsize=1)
def _office_once() -> Floorplan:
    from indoor_explorers.env.maps.office import office

    return office()
