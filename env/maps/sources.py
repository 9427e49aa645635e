"""Where a scenario's maps come from: a generator, files, or the bundled office."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.thesis import Room, draw_room
from indoor_explorers.env.randomness import Stream, stream_key


class _Source(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)

    @property
    def count(self) -> int:
        """Maps to be explored with every seed; a generator counts as one, its seeds make the maps."""
        return 1

    @property
    def generated(self) -> bool:
        """True when the seed makes the map, so that another attempt gives another map."""
        return False

    def floorplan(self, index: int, seed: int, attempt: int = 0) -> Floorplan:
        """Return map ``index`` (0 to count - 1) for an episode seed."""
        raise NotImplementedError

    def identity(self) -> Any:
        """Return what tells this source from others, as JSON: the cells of files, not their paths."""
        return self.model_dump(mode="json")


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
    rows: int = Field(0, ge=0, le=1000)
    """Rows of a lattice of rectangles, used instead of ``obstacles``; 0 for none."""
    columns: int = Field(0, ge=0, le=1000)
    """Columns of the lattice."""
    noise: int = Field(0, ge=0, le=2048)
    """Cells that a rectangle of the lattice may be moved by, up to, in each direction."""

    @model_validator(mode="after")
    def _consistent(self) -> ThesisMaps:
        smallest, largest = self.obstacle_size
        if not 1 <= smallest <= largest:
            raise ValueError(f"obstacle_size is {[smallest, largest]}, expected 1 <= smallest <= largest")
        if (self.rows > 0) != (self.columns > 0):
            raise ValueError(f"rows is {self.rows} and columns {self.columns}, expected both or neither above 0")
        if self.noise > 0 and self.rows == 0:
            raise ValueError(f"noise is {self.noise} without a lattice; set rows and columns too")
        return self

    @property
    def generated(self) -> bool:
        """True: every seed has a room of its own."""
        return True

    @property
    def room(self) -> Room:
        """The settings for compiled code."""
        smallest, largest = self.obstacle_size
        return Room(self.obstacles, smallest, largest, self.margin, self.rows, self.columns, self.noise)

    def floorplan(self, index: int, seed: int, attempt: int = 0) -> Floorplan:
        """Draw the room of an episode seed."""
        truth = np.empty((self.height, self.width), np.uint8)
        draw_room(self.room, np.uint64(stream_key(seed, Stream.MAP, attempt)), truth)
        return Floorplan(truth, "thesis")


class FileMaps(_Source):
    """Maps read from files: ROS map_server YAML, or an image."""

    source: Literal["files"] = "files"
    paths: tuple[str, ...] = Field(min_length=1)
    """Files, each explored with every seed."""
    resolution: float | None = Field(None, gt=0.0)
    """Metres a cell to resample to; None keeps the file's. A plain image counts one pixel as one metre."""

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


MapSource = ThesisMaps | FileMaps | OfficeMap


@lru_cache(maxsize=64)
def _read_once(path: str, resolution: float | None) -> Floorplan:
    from indoor_explorers.env.maps.files import read_map

    return read_map(path, resolution)


@lru_cache(maxsize=1)
def _office_once() -> Floorplan:
    from indoor_explorers.env.maps.office import office

    return office()
