"""Floor plans of schools, offices and university buildings, each in a style of its own.

Corridors are laid in one of nine shapes, rows of rooms are placed along them in sections, and doors make a tree of all
spaces with some loops. Some buildings are furnished, some plans turned, and some have uneven walls as a map built by a
robot has.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.randomness import Stream, generator
from indoor_explorers.env.maps.base import GeneratedMaps
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.generators.floors.doors import doors, open_doors
from indoor_explorers.env.maps.generators.floors.finish import (
    furnished,
    mirrored,
    ragged,
    rooms_of,
    set_fire_doors,
    set_niches,
    turned,
)
from indoor_explorers.env.maps.generators.floors.sections import Filling
from indoor_explorers.env.maps.generators.floors.site import Site
from indoor_explorers.env.maps.generators.floors.skeletons import Skeleton, draw_skeleton, fitted, size_of
from indoor_explorers.env.maps.generators.floors.style import draw_style
from indoor_explorers.env.search.connected_parts import extent, largest_part

#: Plans drawn at most for one map; of those that miss its area, the nearest is taken.
TRIES = 8
#: A plan is near enough to the area that was drawn for it when the logarithm of their ratio is below this.
NEAR = 0.25
#: Where between the logarithms of the smallest and the largest area the most frequent one lies.
MODE = 0.85


class FloorsMaps(GeneratedMaps):
    """Random floor plans of schools, offices and university buildings, with solid cells around them."""

    source: Literal["floors"] = "floors"
    height: int = Field(160, ge=32, le=2048)
    """Cells; smaller plans lie somewhere in the map."""
    width: int = Field(224, ge=32, le=2048)
    """Cells."""
    resolution: float = Field(0.5, ge=0.25, le=2.0)
    """Metres a cell."""
    area: tuple[float, float] = (300.0, 4000.0)
    """Smallest and largest floor in square metres; what the map is too small for is drawn smaller."""
    loops: float = Field(0.08, ge=0.0, le=1.0)
    """Mean share of walls between neighbouring spaces with a door although there is another way."""
    furniture: float = Field(0.08, ge=0.0, le=0.3)
    """Mean share of the floor of a furnished room under furniture; a fifth of the buildings is furnished."""
    turned: float = Field(0.1, ge=0.0, le=1.0)
    """Share of plans turned by any angle, where that fits into the map."""
    ragged: float = Field(0.1, ge=0.0, le=1.0)
    """Share of plans with uneven walls."""

    @model_validator(mode="after")
    def _consistent(self) -> FloorsMaps:
        smallest, largest = self.area
        if not 0.0 < smallest <= largest:
            raise ValueError(f"area is {[smallest, largest]}, expected 0 < smallest <= largest")
        return self

    def floorplan(self, index: int, seed: int, attempt: int = 0) -> Floorplan:
        """Draw the map of an episode seed."""
        return Floorplan.from_free(self.draw(generator(seed, Stream.MAP, attempt)), self.source, self.resolution)

    def draw(self, rng: np.random.Generator) -> Mask:
        """Return the (height, width) mask of the free cells of a random floor."""
        wanted = self._wanted(rng)
        best, miss, aim = np.zeros((self.height, self.width), np.bool_), np.inf, wanted
        for _ in range(TRIES):
            free = self._plan(rng, round(aim))
            short = float(np.log(wanted / free.sum()))
            if abs(short) < miss:
                best, miss = free, abs(short)
            if miss < NEAR:
                break
            aim *= float(np.exp(np.clip(short, -NEAR, NEAR)))
        return best

    def _wanted(self, rng: np.random.Generator) -> float:
        """Return the free cells to aim for: a triangular distribution of their logarithm, most often rather large."""
        smallest, largest = np.log(self.area) - 2.0 * np.log(self.resolution)
        most_often = smallest + MODE * (largest - smallest)
        return float(np.exp(smallest if smallest == largest else rng.triangular(smallest, most_often, largest)))

    def _plan(self, rng: np.random.Generator, floor: int) -> Mask:
        """Return a plan with about ``floor`` free cells."""
        style = draw_style(rng, self.resolution, self.loops, self.furniture)
        skeleton = draw_skeleton(rng, style, floor)
        margin = style.depth + 4
        flip = self._better_turned(rng, skeleton, margin)
        site = Site(*((self.width, self.height) if flip else (self.height, self.width)))
        tall, wide = (_inside(side, margin) for side in site.spaces.shape)
        laid = site.lay(rng, fitted(skeleton, tall, wide), margin)
        Filling(rng, site, style).fill(laid)
        set_fire_doors(rng, site, laid.corridors, style)
        spaces, made = site.spaces, doors(rng, site.spaces, style)
        free = spaces > 0
        open_doors(free, made)
        if style.symmetric:
            free, spaces, made = mirrored(rng, free, spaces, made, free.shape[1] - 2)
        rooms = rooms_of(spaces)
        set_niches(rng, free, rooms, style)
        furnished(rng, free, rooms, style)
        free = largest_part(free)
        if rng.random() < self.turned:
            other = largest_part(turned(free, made, float(rng.uniform(0.0, np.pi / 2.0))))
            free = other if _fits(other, site.spaces.shape) and other.sum() > 0.8 * free.sum() else free
        if rng.random() < self.ragged:
            free = ragged(rng, free, float(rng.uniform(0.03, 0.15)))
        free = _placed(rng, free, site.spaces.shape)
        return np.ascontiguousarray(free.T) if flip else free

    def _better_turned(self, rng: np.random.Generator, skeleton: Skeleton, margin: int) -> bool:
        """Tell whether rows and columns of a skeleton are better swapped; random where it fits either way."""
        _, _, tall, wide = size_of(skeleton)
        height, width = _inside(self.height, margin), _inside(self.width, margin)
        lying, standing = max(tall / height, wide / width), max(tall / width, wide / height)
        return bool(rng.random() < 0.5) if max(lying, standing) <= 1.0 else standing < lying


def _inside(side: int, margin: int) -> int:
    """Return how long a skeleton may be along a side of the map: the rest is for the rooms around it."""
    return max(side - 2 * margin, side // 2)


def _fits(free: Mask, shape: tuple[int, ...]) -> bool:
    """Tell whether a plan fits into a map of a shape with walls around it."""
    inner = free[extent(free)]
    return all(side <= space - 2 for side, space in zip(inner.shape, shape, strict=True))


def _placed(rng: np.random.Generator, free: Mask, shape: tuple[int, ...]) -> Mask:
    """Return a plan in a random place of a map, mirrored at random."""
    inner = free[extent(free)]
    inner = inner[:: int(rng.choice([-1, 1])), :: int(rng.choice([-1, 1]))]
    out = np.zeros(shape, np.bool_)
    row, col = (1 + int(rng.integers(space - side - 1)) for side, space in zip(inner.shape, shape, strict=True))
    out[row : row + inner.shape[0], col : col + inner.shape[1]] = inner
    return out
