"""Pictures of 255 colours for GIFs: one palette for a whole video, in which the frequent colours are exact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image

#: Colours of a palette, one less than a GIF has, whose last one marks unchanged pixels; and the number of exact ones.
COLOURS, EXACT = 255, 64

Picture = NDArray[np.uint8]


class Palette:
    """Choose colours for (h, w, 3) uint8 pictures and turn others like them into indexed images.

    The most frequent colours are kept as they are; the others are clustered, rare ones counting for more than
    their share, so that small discs keep their hue. Pillow's own mapping to a palette would blur even the white
    of the page.
    """

    def __init__(self, pictures: Sequence[Picture]) -> None:
        codes = np.concatenate([_codes(picture).ravel() for picture in pictures])
        colours, counts = np.unique(codes, return_counts=True)
        ranked = np.argsort(-counts, kind="stable")
        entries, others = _rgb(colours[ranked[:EXACT]]), ranked[EXACT:]
        if len(others):
            weighted = _rgb(colours[others].repeat(1 + np.log2(counts[others]).astype(int)))
            clusters = Image.fromarray(weighted[None]).quantize(COLOURS - EXACT, Image.Quantize.MEDIANCUT)
            entries = np.concatenate((entries, np.array(clusters.getpalette(), np.uint8).reshape(-1, 3)))
        self._entries = entries[:COLOURS]
        self._index = np.full(2**24, COLOURS, np.uint8)

    def image(self, picture: Picture) -> Image.Image:
        """Return a picture as an indexed image, each pixel the nearest colour there is."""
        codes = _codes(picture)
        indices = self._index[codes]
        if (new := indices == COLOURS).any():
            colours = np.unique(codes[new])
            self._index[colours] = self._nearest(_rgb(colours))
            indices = self._index[codes]
        image = Image.fromarray(indices)
        image.putpalette(self._entries.tobytes())  # grey values become indices
        return image

    def _nearest(self, colours: Picture) -> NDArray[np.intp]:
        away = colours[:, None, :].astype(np.int32) - self._entries
        return np.asarray((away**2).sum(axis=2).argmin(axis=1))


def _codes(picture: Picture) -> NDArray[np.int32]:
    return np.asarray(picture.astype(np.int32) @ np.array([65536, 256, 1], np.int32))


def _rgb(codes: NDArray[np.int32]) -> Picture:
    return np.stack((codes >> 16, codes >> 8 & 255, codes & 255), axis=1).astype(np.uint8)
