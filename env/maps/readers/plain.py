"""Plain pictures: bright is free, and a coloured spot may mark where to start."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.readers.image import Picture, read_picture
from indoor_explorers.env.maps.readers.opening import Fits

#: A pixel is free above this luminance (0 black, 255 white).
FREE_LUMINANCE = 127.5
#: A pixel is coloured when its strongest channel is this far above its weakest (0 grey, 255 pure).
COLOURED = 128
#: Grey levels that mark the start: DungeonMaps' yellow spot as scikit-image (208) and Pillow (203) turn it to grey.
START_LEVELS = (208, 203)
#: A picture of more grey levels than this is a photograph or a scan, where a level means nothing.
MOST_LEVELS = 4
#: A mark covers at most this share of the picture, or a single pixel.
LARGEST_MARK = 0.1


def read_plain(path: Path, fits: Fits | None = None) -> tuple[Belief, Cell | None]:
    """Read a plain picture; return (H, W) uint8 cells, 1 free or 2 occupied, and the marked start pixel, if any.

    A pixel is free above :data:`FREE_LUMINANCE` and in the mark, see :func:`find_mark`. Transparent pixels are white.
    The start is the pixel of the mark that is nearest to its middle. ``fits`` is called with one metre a pixel.
    """
    picture = read_picture(path, fits).on_white()
    free = picture.luminance() > FREE_LUMINANCE
    mark = find_mark(picture)
    start = None
    if mark is not None:
        free |= mark
        pixels = np.argwhere(mark)
        row, col = pixels[int(np.argmin(((pixels - pixels.mean(axis=0)) ** 2).sum(axis=1)))]
        start = int(row), int(col)
    return np.where(free, FREE, OCCUPIED).astype(np.uint8), start


def find_mark(picture: Picture) -> Mask | None:
    """Return the (H, W) mask of the start mark, or None where a picture has none.

    In a colour picture the mark is the only spot of strong colour, whatever the colour; in a grey one of few levels
    it is the only spot of one of :data:`START_LEVELS`, the convention of DungeonMaps and ARiADNE (Cao et al. 2023).
    Pixels of a spot touch by sides or corners. Several spots, or a large one, are part of a drawing.
    """
    channels = picture.channels
    spread = _spread(channels)
    if spread.any():
        return _only_spot(spread >= COLOURED)
    grey: NDArray[np.uint8] = channels[..., 0]
    levels = np.flatnonzero(np.bincount(grey.ravel(), minlength=256))
    if len(levels) > MOST_LEVELS:
        return None
    found = [level for level in START_LEVELS if level in levels]
    return _only_spot(grey == found[0]) if found else None


def _spread(channels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the (H, W) difference of each pixel's strongest and weakest channel."""
    low = high = channels[..., 0]
    for k in range(1, channels.shape[2]):
        low, high = np.minimum(low, channels[..., k]), np.maximum(high, channels[..., k])
    return np.asarray(high - low)


def _only_spot(mask: Mask) -> Mask | None:
    from scipy import ndimage  # here, since it takes long to import

    if not 0 < mask.sum() <= max(1.0, LARGEST_MARK * mask.size):
        return None
    return mask if ndimage.label(mask, np.ones((3, 3), np.int8))[1] == 1 else None
