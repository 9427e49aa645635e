"""What generators of maps of several levels share: a scale, a height at which teams start, and places in a plan."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.randomness import Stream, generator
from indoor_explorers.env.maps.base import GeneratedMaps, check_sizes
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.search.connected_parts import largest_part

#: Rows and columns of a rectangle.
Place = tuple[slice, slice]


class VolumeMaps(GeneratedMaps):
    """Generated maps of several levels, to scale; each marks a start at the height of a plane's flight."""

    resolution: float = Field(0.5, gt=0.0)
    """Metres a cell."""
    start_level: int = Field(2, ge=0, le=255)
    """The level that teams start on, the highest one where the map has fewer: on its largest part of one height."""

    def floorplan(self, index: int, seed: int, attempt: int = 0) -> Floorplan:
        """Draw the map of an episode seed, and its start."""
        rng = generator(seed, Stream.MAP, attempt)
        free = self.draw(rng)
        level = min(self.start_level, len(free) - 1)
        row, col = rng.choice(np.argwhere(largest_part(free[level])))
        start = int(level * (self.height + 1) + row), int(col)
        return Floorplan.from_free(free, self.source, self.resolution, start=start)

    def rectangle(self, rng: np.random.Generator, sizes: tuple[int, int]) -> Place:
        """Return a random rectangle between the outer walls, its sides within ``sizes``."""
        found = []
        for side in (self.height, self.width):
            length = int(rng.integers(sizes[0], min(sizes[1], side - 2) + 1))
            first = int(rng.integers(1, side - length))
            found.append(slice(first, first + length))
        return found[0], found[1]


def check_fits(maps: GeneratedMaps, name: str, sizes: tuple[int, int]) -> None:
    """Raise :class:`ValueError` unless sizes are in order and the smallest fits between the outer walls of maps."""
    check_sizes(name, sizes)
    if sizes[0] > min(maps.height, maps.width) - 2:
        raise ValueError(f"{name} begins at {sizes[0]}, more than fits between the walls; lower it")


def wide(plan: Mask) -> Mask:
    """Return the cells of a plan (H, W) that are in a free square of two by two cells; the others are passages."""
    from scipy import ndimage  # here, since it takes long to import

    return np.asarray(ndimage.binary_opening(plan, np.ones((2, 2), np.bool_)))
