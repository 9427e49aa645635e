"""The base classes of map sources and of map generators."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.randomness import Stream, generator
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.plugins import is_own, source_hash


class BaseMaps(BaseModel):
    """Describe a source of maps: frozen, validated, and identified in a scenario by ``source``."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)

    @property
    def count(self) -> int:
        """Number of maps that are explored with every seed; 1 for a generator, whose maps come from the seeds."""
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


class GeneratedMaps(BaseMaps):
    """A generator of maps; subclasses define :meth:`draw`, and may have settings of their own.

    Maps of this package's generators have a solid border and one connected free part.
    """

    source: str = ""
    """Its name; by default ``module:Class``."""
    height: int = Field(64, ge=5, le=2048)
    """Cells."""
    width: int = Field(64, ge=5, le=2048)
    """Cells."""

    @model_validator(mode="after")
    def _named(self) -> Self:
        if not self.source:
            object.__setattr__(self, "source", f"{type(self).__module__}:{type(self).__qualname__}")
        return self

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
        """Return the (height, width) mask of the free cells of a random map."""
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
