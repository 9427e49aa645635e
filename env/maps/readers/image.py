"""Pictures of maps: PNG, PGM and BMP files, damaged and malicious ones refused, and the cells of plain pictures."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.readers.opening import MAX_PIXELS, Fits, check_pixels, decoding

#: The most bytes of a PNM picture in text (P1 to P3), and the most comments in it.
MAX_TEXT, MAX_COMMENTS = 10_000_000, 1_000
#: The most bytes of the header of a PNM picture; real ones have about 100.
MAX_HEADER = 10_000
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

_FORMATS = ("PNG", "PPM", "BMP")
_DEEP = ("I", "I;16", "I;16B", "I;16L", "I;16N")


@dataclass(frozen=True, eq=False)
class Picture:
    """Hold a decoded picture."""

    channels: NDArray[np.uint8]
    """(H, W, 1) grey or (H, W, 3) red, green and blue; 16-bit files are cut to their upper 8 bits."""
    opaque: Mask | None
    """(H, W) bool: pixels without transparency; None when the file has no alpha channel."""
    alpha: NDArray[np.uint8] | None = None
    """(H, W): 0 transparent to 255 opaque; None when the file has no alpha channel."""

    def on_white(self) -> Picture:
        """Return the picture as it looks on white paper."""
        if self.alpha is None:
            return self
        alpha = self.alpha[..., None].astype(np.uint16)
        return Picture(((self.channels * alpha + 255 * (255 - alpha) + 127) // 255).astype(np.uint8), None)

    def luminance(self) -> NDArray[np.float32]:
        """Return the (H, W) luminance (ITU-R 601), 0 to 255; alpha is ignored."""
        if self.channels.shape[2] == 1:
            return self.channels[..., 0].astype(np.float32)
        out = self.channels[..., 0] * np.float32(299)
        out += self.channels[..., 1] * np.float32(587)  # whole numbers below 2**24: exact in any order
        out += self.channels[..., 2] * np.float32(114)
        out /= np.float32(1000)
        return out


def read_picture(path: Path, fits: Fits | None = None, metres: float = 1.0) -> Picture:
    """Decode a PNG, PGM (PNM) or BMP file of at most :data:`MAX_PIXELS` pixels.

    ``fits`` checks its size, at ``metres`` a pixel, before any pixel is decoded.

    Raises :class:`InputError` with one line for a file that is missing, truncated, too large or no picture.
    """
    with decoding(path, "a whole picture"):
        _check_pnm(path)
        try:
            return _decode(path, fits, metres)
        except UnidentifiedImageError as error:
            received = "an empty file" if path.stat().st_size == 0 else "a file of another kind, or a broken header"
            raise InputError(f"{path}: expected a PNG, PGM or BMP picture, got {received}; save it again") from error
        except Image.DecompressionBombError as error:
            raise InputError(f"{path}: expected at most {MAX_PIXELS:,} pixels, got far more; scale it down") from error


def _check_pnm(path: Path) -> None:
    """Refuse a PNM picture with a long header or text, which Pillow reads byte by byte."""
    with path.open("rb") as file:
        head = file.read(MAX_HEADER)
        words = re.sub(rb"#[^\r\n]*", b"", head).split(maxsplit=4)
        kind = words[0] if head.startswith(b"P") and words else b""
        if len(words) < (3 if kind in (b"P1", b"P4") else 4) and kind and len(head) == MAX_HEADER:
            raise InputError(
                f"{path}: expected a header of at most {MAX_HEADER:,} bytes, got a longer one; save it again"
            )
        if kind not in (b"P1", b"P2", b"P3"):
            return
        text = head + file.read(MAX_TEXT)
    if len(text) > MAX_TEXT:
        raise InputError(f"{path}: expected at most {MAX_TEXT:,} bytes of text, got more; save it as a binary picture")
    if text.count(b"#") > MAX_COMMENTS:
        raise InputError(f"{path}: expected at most {MAX_COMMENTS:,} comments, got more; save it without them")


def _decode(path: Path, fits: Fits | None, metres: float) -> Picture:
    with Image.open(path, formats=_FORMATS) as image:
        width, height = image.size
        check_pixels(path, (height, width))
        if fits is not None:
            fits((height, width), metres)
        if image.mode in _DEEP:
            return Picture((np.asarray(image) >> 8).clip(0, 255).astype(np.uint8)[..., None], None)
        if image.mode in ("1", "L"):
            return Picture(np.asarray(image.convert("L"))[..., None], None)
        if image.mode == "LA":
            return _split(np.asarray(image))
        if image.has_transparency_data:
            return _split(np.asarray(image.convert("RGBA")))
        return Picture(np.asarray(image.convert("RGB")), None)


def _split(pixels: NDArray[np.uint8]) -> Picture:
    return Picture(pixels[..., :-1], np.asarray(pixels[..., -1] == 255), pixels[..., -1])


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
