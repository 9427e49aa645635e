"""Sources of a scenario's maps: generators, files, and the bundled office."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from functools import lru_cache
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import numpy as np
from pydantic import (
    Field,
    SerializationInfo,
    SerializerFunctionWrapHandler,
    ValidationError,
    ValidatorFunctionWrapHandler,
    WrapSerializer,
    WrapValidator,
    model_validator,
)

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import expanded
from indoor_explorers.env.maps.base import BaseMaps, GeneratedMaps, MapReader
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.generators.cave import CaveMaps
from indoor_explorers.env.maps.generators.floors.plans import FloorsMaps
from indoor_explorers.env.maps.generators.halls import HallsMaps
from indoor_explorers.env.maps.generators.homes import HomesMaps
from indoor_explorers.env.maps.generators.interiors import InteriorsMaps
from indoor_explorers.env.maps.generators.maze import MazeMaps
from indoor_explorers.env.maps.generators.offices import OfficesMaps
from indoor_explorers.env.maps.generators.racks import RacksMaps
from indoor_explorers.env.maps.generators.rooms import RoomsMaps
from indoor_explorers.env.maps.generators.storeys import StoreysMaps
from indoor_explorers.env.maps.generators.thesis import ThesisMaps
from indoor_explorers.env.maps.readers.npy import levels_of
from indoor_explorers.env.maps.readers.rmf import ENDING, BuildingSettings
from indoor_explorers.env.plugins import MAPS, declared, load_plugin

__all__ = [
    "SOURCES",
    "AnyMaps",
    "CaveMaps",
    "FileMaps",
    "FloorsMaps",
    "HallsMaps",
    "HomesMaps",
    "InteriorsMaps",
    "MapSource",
    "MazeMaps",
    "OfficeMap",
    "OfficesMaps",
    "RacksMaps",
    "RoomsMaps",
    "StoreysMaps",
    "ThesisMaps",
]


#: The drawing of the office, its characters, and metres a cell: the floor is 40 m by 24 m, its corridors 1.6 m and most
#: of its doors 0.8 m wide.
OFFICE, OFFICE_RESOLUTION = "readers/office.txt", 0.4
WALL, FURNITURE, FLOOR = "#", "o", "."
#: Endings of files that may have several levels.
VOLUMES = (".npy", ENDING, ".bt", ".stl", ".ply", ".obj", ".pcd")


class FileMaps(MapReader):
    """Maps read from files of the kinds that :func:`~indoor_explorers.env.maps.files.read_map` knows.

    All have as many levels as the tallest one: the others get solid levels on top, which change no digest.
    """

    source: Literal["files"] = "files"
    resolution: float | None = Field(None, gt=0.0)
    """Metres a cell to resample to; None keeps the file's. Files without a scale count a pixel as one metre."""
    building: BuildingSettings = BuildingSettings()
    """How buildings of several storeys are read."""
    least_levels: int = Field(1, ge=1, le=4096)
    """Levels that the maps have at least, for the same flights whatever other maps are flown."""
    levels: int = Field(1, ge=1, le=4096)
    """Levels of the maps, counted in the files that are there."""

    @model_validator(mode="after")
    def _counted(self) -> FileMaps:
        volumes = [expanded(path) for path in self.paths if path.lower().endswith(VOLUMES)]
        found = map(self._levels_in, volumes) if volumes else [self.levels]
        object.__setattr__(self, "levels", max(self.least_levels, *found))
        return self

    def alone(self, index: int) -> FileMaps:
        """Return the maps of one of the files: its map has the levels that it has without the others."""
        return FileMaps.model_validate(self.model_dump() | {"paths": (self.paths[index],)})

    def _levels_in(self, path: Path) -> int:
        """Return how many levels the map of a file has; those that were given where it cannot be read."""
        if not path.is_file():
            return self.levels
        if path.suffix.lower() == ".npy":
            return levels_of(path)
        with suppress(InputError):  # told where the map is read
            return _read_once(str(path), self.resolution, self.building, 1).level_count
        return self.levels

    @property
    def level_count(self) -> int:
        """Levels of the maps."""
        return self.levels

    def plan(self, path: Path) -> Floorplan:
        """Return the map of a file, with solid levels on top where it has fewer than others."""
        return _read_once(str(path), self.resolution, self.building, self.levels)


class OfficeMap(BaseMaps):
    """The bundled office floor."""

    source: Literal["office"] = "office"

    def floorplan(self, index: int, seed: int, attempt: int = 0) -> Floorplan:
        """Return the office; the seed does not matter."""
        return office()

    def identity(self) -> Any:
        """Return the digest of the office's cells."""
        return {"source": self.source, "cells": [office().digest]}


MapSource = (
    ThesisMaps
    | RoomsMaps
    | OfficesMaps
    | FloorsMaps
    | HallsMaps
    | HomesMaps
    | CaveMaps
    | MazeMaps
    | StoreysMaps
    | InteriorsMaps
    | RacksMaps
    | FileMaps
    | OfficeMap
)

#: The kinds of maps by name.
SOURCES: dict[str, type[BaseMaps]] = {kind.model_fields["source"].default: kind for kind in get_args(MapSource)}


def map_class(source: Any) -> type[BaseMaps] | None:
    """Return the class of a kind of map by name, that of a plug-in too; None where there is no such name.

    Raises:
        InputError: a plug-in cannot be imported, or is no source of maps.

    """
    if not isinstance(source, str):
        return None
    if source in SOURCES or not (":" in source or source in declared(MAPS)):
        return SOURCES.get(source)
    kind = load_plugin(MAPS, source, "map source", SOURCES)
    if not (isinstance(kind, type) and issubclass(kind, GeneratedMaps | MapReader)):
        raise InputError(f"map source {source!r}: expected a subclass of GeneratedMaps or MapReader, got {kind!r}")
    return kind


def _validated(value: Any, handler: ValidatorFunctionWrapHandler) -> Any:
    """Validate maps of plug-ins by their own class, all others as members of the union."""
    if isinstance(value, BaseMaps):
        return value if not isinstance(value, get_args(MapSource)) else handler(value)
    source = value.get("source") if isinstance(value, Mapping) else None
    kind = map_class(source)
    if kind is None or source in SOURCES:
        return handler(value)
    try:
        return kind.model_validate(value)
    except ValidationError as error:
        first = error.errors()[0]
        raise ValueError(f"{source}: {'.'.join(map(str, first['loc']))}: {first['msg']}") from error


def _serialised(value: Any, handler: SerializerFunctionWrapHandler, info: SerializationInfo) -> Any:
    """Serialise maps of plug-ins by their own class."""
    return handler(value) if isinstance(value, get_args(MapSource)) else value.model_dump(mode=info.mode)


#: The maps of a scenario: a kind of this package, or a plug-in of the group ``indoor_explorers.maps``.
AnyMaps = Annotated[
    Annotated[MapSource, Field(discriminator="source")], WrapValidator(_validated), WrapSerializer(_serialised)
]


@lru_cache(maxsize=256)
def _read_once(path: str, resolution: float | None, building: BuildingSettings, levels: int) -> Floorplan:
    from indoor_explorers.env.maps.files import read_map

    if levels > 1:
        return _read_once(path, resolution, building, 1).raised(levels)
    return read_map(path, resolution, building)


@lru_cache(maxsize=1)
def office() -> Floorplan:
    """Return the office: 60 x 100 cells, a corridor loop around an open-plan area, rooms on both sides of it."""
    return drawn(resources.files(__package__).joinpath(OFFICE).read_text("ascii"), "office", OFFICE_RESOLUTION)


def drawn(text: str, name: str, resolution: float | None = None) -> Floorplan:
    """Turn a drawing of equally long lines of ``#``, ``o`` and ``.`` into a floor plan; ``.`` alone is free.

    Raises :class:`InputError` for a line of another length or another character.
    """
    lines = text.split()
    for number, line in enumerate(lines, 1):
        if len(line) != len(lines[0]):
            raise InputError(
                f"{name}: expected {len(lines[0])} characters in line {number}, got {len(line)}; fix that line"
            )
        if unknown := set(line) - {WALL, FURNITURE, FLOOR}:
            raise InputError(
                f"{name}: expected only {WALL!r}, {FURNITURE!r} and {FLOOR!r} in line {number}, "
                f"got {min(unknown)!r}; replace it"
            )
    return Floorplan.from_free(np.array([list(line) for line in lines]) == FLOOR, name, resolution)
