"""The base classes of map sources: of map generators, and of readers of map files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, field_validator, model_validator

from indoor_explorers.env.errors import InputError, described
from indoor_explorers.env.files import expanded
from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.randomness import Stream, generator
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.plugins import is_own, source_hash

#: Placeholder for the path of a map file that must not be known.
HIDDEN = "(not told)"


class BaseMaps(BaseModel):
    """Describe a source of maps: frozen, validated, and identified in a scenario by ``source``."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)

    source: str = ""
    """Its name; by default ``module:Class``."""

    @model_validator(mode="after")
    def _named(self) -> Self:
        if not self.source:
            object.__setattr__(self, "source", f"{type(self).__module__}:{type(self).__qualname__}")
        return self

    @property
    def count(self) -> int:
        """Number of maps that are explored with every seed; 1 for a generator, whose maps come from the seeds."""
        return 1

    @property
    def level_count(self) -> int:
        """Levels of the maps; 1 for plain ones."""
        return 1

    @property
    def generated(self) -> bool:
        """True when the seed makes the map, so that another attempt gives another map."""
        return False

    def floorplan(self, index: int, seed: int, attempt: int = 0) -> Floorplan:
        """Return map ``index`` (0 to count - 1) for an episode seed."""
        raise NotImplementedError

    def without_files(self) -> Self:
        """Return the settings that a UAV may know: all but the names of map files."""
        return self

    def identity(self) -> Any:
        """Return the identity of this source as JSON; files are identified by their cells."""
        return self.model_dump(mode="json")


class MapReader(BaseMaps):
    """A reader of map files; subclasses define :meth:`read`, and may have settings of their own.

    Maps are identified by their cells, and a UAV is not told the names of the files.
    """

    paths: tuple[str, ...] = Field(min_length=1)
    """Files, each explored with every seed."""
    _held: dict[int, Floorplan] = PrivateAttr(default_factory=dict)

    @field_validator("paths")
    @classmethod
    def _at_home(cls, paths: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(str(expanded(path)) if path.startswith("~") else path for path in paths)

    @property
    def count(self) -> int:
        """One map for each file."""
        return len(self.paths)

    def floorplan(self, index: int, seed: int, attempt: int = 0) -> Floorplan:
        """Read file ``index``, whatever the seed; plans of files with equal names have their folders in their names."""
        if index in self._held:
            return self._held[index]
        path = Path(self.paths[index])
        plan = self.plan(path)
        alike = sum(Path(other).stem == path.stem for other in self.paths) > 1
        return replace(plan, name=f"{path.parent.name}/{path.stem}") if alike else plan

    def plan(self, path: Path) -> Floorplan:
        """Return the map of a file; raise :class:`InputError` with the path and whatever :meth:`read` raised."""
        return _read_once(self, path)

    def read(self, path: Path) -> Mask:
        """Return the mask of the free cells of a file's map, (height, width) or (levels, height, width)."""
        raise NotImplementedError

    def holding(self, plans: Mapping[int, Floorplan]) -> Self:
        """Return the same maps with some floor plans in memory, by index, for machines without the files."""
        held = self.model_copy()
        held._held = dict(plans)
        return held

    def without_files(self) -> Self:
        """Return the same number of maps with placeholder paths."""
        return self.model_validate(self.model_dump() | {"paths": (HIDDEN,) * self.count})

    def identity(self) -> Any:
        """Return the digests of the maps' cells."""
        return {"source": self.source, "cells": [self.floorplan(index, 0).digest for index in range(self.count)]}


@lru_cache(maxsize=256)
def _read_once(maps: MapReader, path: Path) -> Floorplan:
    try:
        return Floorplan.from_free(maps.read(path), path.stem)
    except Exception as error:
        raise InputError(f"{path}: expected a map that {maps.source} reads, got {described(error)}") from error


class GeneratedMaps(BaseMaps):
    """A generator of maps; subclasses define :meth:`draw`, and may have settings of their own.

    Maps of this package's generators have a solid border and one connected free part.
    """

    height: int = Field(64, ge=5, le=2048)
    """Cells."""
    width: int = Field(64, ge=5, le=2048)
    """Cells."""

    @property
    def generated(self) -> bool:
        """True: every seed has a map of its own."""
        return True

    def identity(self) -> Any:
        """Return the settings, and for a plug-in also a hash of its source file."""
        return super().identity() | ({} if is_own(type(self)) else {"code": source_hash(type(self))})

    def floorplan(self, index: int, seed: int, attempt: int = 0) -> Floorplan:
        """Draw the map of an episode seed."""
        return Floorplan.from_free(self.draw(generator(seed, Stream.MAP, attempt)), self.source)

    def draw(self, rng: np.random.Generator) -> Mask:
        """Return the mask of the free cells of a random map, (height, width) or (levels, height, width)."""
        raise NotImplementedError


def check_sizes(name: str, sizes: tuple[int, int]) -> None:
    """Raise :class:`ValueError` unless ``sizes`` are a smallest and a largest one, from 1 on."""
    smallest, largest = sizes
    if not 1 <= smallest <= largest:
        raise ValueError(f"{name} is {[smallest, largest]}, expected 1 <= smallest <= largest")


def check_room(name: str, side: int, least: int, why: str) -> None:
    """Raise :class:`ValueError` when a side of the map is too short; ``why`` names what must fit into it."""
    if side < least:
        raise ValueError(f"{name} is {side}, expected at least {least} ({why}); enlarge it or shrink what is in it")
