"""Draw walls, rooms and doors given in metres as pixels of :data:`PIXEL` metres."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.maps.readers.opening import MAX_PIXELS, Fits

#: Metres a pixel.
PIXEL = 0.1
#: Thickness of a drawn wall in pixels.
WALL = 2
#: The farthest a point may be from the origin, in metres.
FARTHEST = 1e6


@dataclass(frozen=True, eq=False)
class Sheet:
    """A sheet to draw on: x runs along the columns and y along the rows."""

    origin: NDArray[np.float64]
    """(2,) the x and y of its upper left corner, in metres."""
    shape: tuple[int, int]
    """(H, W) in pixels."""

    @classmethod
    def around(cls, path: Path, points: NDArray[np.float64], margin: float, fits: Fits | None = None) -> Sheet:
        """Return a sheet for (n, 2) ``points`` in metres and ``margin`` metres around them; ``fits`` checks its size.

        Raises :class:`InputError` with one line when it would be too large.
        """
        far = float(np.abs(points).max())
        if far > FARTHEST:
            raise InputError(
                f"{path}: expected points within {FARTHEST:,.0f} m of the origin, got {far:.3g}; correct it"
            )
        low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
        width, height = (math.ceil(side) for side in (high - low) / PIXEL)
        if height * width > MAX_PIXELS:
            raise InputError(
                f"{path}: expected a plan of at most {MAX_PIXELS:,} pixels of {PIXEL:g} m, got {height:,} x {width:,}; "
                "correct its points, or its scale"
            )
        if fits is not None:
            fits((height, width), PIXEL)
        return cls(low, (height, width))

    def lines(self, paths: Iterable[NDArray[np.float64]]) -> Mask:
        """Draw lines of :data:`WALL` pixels along (n, 2) paths in metres; return the (H, W) mask."""
        image, draw = self._blank()
        for path in paths:
            draw.line(self._pixels(path), fill=1, width=WALL)
        return np.array(image)

    def areas(self, outlines: Iterable[NDArray[np.float64]]) -> Mask:
        """Fill (n, 2) outlines in metres; return the (H, W) mask."""
        image, draw = self._blank()
        for outline in outlines:
            draw.polygon(self._pixels(outline), fill=1)
        return np.array(image)

    def discs(self, centres: NDArray[np.float64], diameter: float) -> Mask:
        """Fill discs around (n, 2) centres in metres, except for those beyond the sheet; return the (H, W) mask."""
        image, draw = self._blank()
        radius = diameter / 2 / PIXEL
        for x, y in self._pixels(centres):
            if -radius <= x <= self.shape[1] + radius and -radius <= y <= self.shape[0] + radius:
                draw.ellipse([x - radius, y - radius, x + radius, y + radius], fill=1)
        return np.array(image)

    def _blank(self) -> tuple[Image.Image, ImageDraw.ImageDraw]:
        image = Image.new("1", self.shape[::-1])
        return image, ImageDraw.Draw(image)

    def _pixels(self, points: NDArray[np.float64]) -> list[tuple[float, float]]:
        return [(float(x), float(y)) for x, y in (points - self.origin) / PIXEL]


def within(mask: Mask, radius: int) -> Mask:
    """Mark the (H, W) pixels whose centre is at most ``radius`` pixels from that of one in ``mask``."""
    widths = [math.isqrt(radius**2 - down**2) for down in range(radius + 1)]
    across, near = mask.copy(), mask.copy()
    for width in range(radius + 1):
        inner = max(mask.shape[1] - width, 0)
        across[:, width:] |= mask[:, :inner]
        across[:, :inner] |= mask[:, width:]
        for down in (down for down in range(radius + 1) if widths[down] == width):
            inner = max(mask.shape[0] - down, 0)
            near[down:] |= across[:inner]
            near[:inner] |= across[down:]
    return near
