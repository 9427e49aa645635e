"""Numbers packed for the page: variable-length integers, bits and 16-bit shares, as base64 text."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray


def packed(numbers: Iterable[int]) -> bytes:
    """Pack whole numbers >= 0, seven bits a byte, lowest first, the top bit set where more follow."""
    out = bytearray()
    for number in numbers:
        while number > 0x7F:
            out.append(number & 0x7F | 0x80)
            number >>= 7
        out.append(number)
    return bytes(out)


def unpacked(data: bytes) -> Iterator[int]:
    """Yield the numbers that :func:`packed` wrote."""
    number = shift = 0
    for byte in data:
        number |= (byte & 0x7F) << shift
        shift += 7
        if not byte & 0x80:
            yield number
            number = shift = 0


def folded(number: int) -> int:
    """Map 0, -1, 1, -2, 2, ... to 0, 1, 2, 3, 4, ..."""
    return 2 * number if number >= 0 else -2 * number - 1


def unfolded(number: int) -> int:
    """Undo :func:`folded`."""
    return -(number + 1) // 2 if number % 2 else number // 2


def runs(places: NDArray[np.int64]) -> list[int]:
    """Return gap and length - 1 of each run of consecutive numbers in sorted ``places``, one after the other."""
    if not len(places):
        return []
    cuts = np.flatnonzero(np.diff(places) != 1)
    starts = places[np.concatenate(([0], cuts + 1))]
    ends = places[np.concatenate((cuts, [len(places) - 1]))]
    gaps = starts - np.concatenate(([0], ends[:-1] + 1))
    return np.column_stack((gaps, ends - starts)).ravel().tolist()


def text(data: bytes) -> str:
    """Return base64 text."""
    return base64.b64encode(data).decode("ascii")


def bits(mask: NDArray[np.bool_]) -> str:
    """Return a mask as base64, eight cells a byte, row by row, highest bit first."""
    return text(np.packbits(mask.ravel()).tobytes())


def shares(values: NDArray[np.float64]) -> str:
    """Return shares from 0 to 1 as base64 of little-endian 16-bit numbers."""
    return text(np.round(np.clip(values, 0, 1) * 65535).astype("<u2").tobytes())
