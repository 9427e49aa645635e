"""Packs numbers for the page: variable-length integers, bits and 16-bit shares, as base64 text."""

from __future__ import annotations

import base64
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray


def packed(numbers: ArrayLike) -> bytes:
    """Pack whole numbers >= 0 in bytes of seven bits, lowest first; the top bit says that more follow."""
    values = np.asarray(numbers, np.uint64)
    lengths = np.ones(len(values), np.int64)
    for shift in range(7, 64, 7):
        lengths += values >> np.uint64(shift) > 0
    starts = np.cumsum(lengths) - lengths
    out = np.zeros(lengths.sum(), np.uint8)
    for place in range(lengths.max(initial=0)):
        there = lengths > place
        septets = (values[there] >> np.uint64(7 * place)) & np.uint64(0x7F)
        out[starts[there] + place] = septets | np.where(lengths[there] > place + 1, 0x80, 0).astype(np.uint64)
    return out.tobytes()


def folded(numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """Map 0, -1, 1, -2, 2, ... to 0, 1, 2, 3, 4, ..."""
    return np.where(numbers >= 0, 2 * numbers, -2 * numbers - 1)


class Keyed(NamedTuple):
    """Numbers sorted by key; numbers of the same key keep their order."""

    keys: NDArray[np.int64]
    numbers: NDArray[np.int64]

    def then(self, *others: Keyed) -> Keyed:
        """Return the numbers of all arguments by key; within a key in the order of the arguments."""
        keys = np.concatenate([self.keys, *(other.keys for other in others)])
        numbers = np.concatenate([self.numbers, *(other.numbers for other in others)])
        order = np.argsort(keys, kind="stable")
        return Keyed(keys[order], numbers[order])


def runs(keys: NDArray[np.int64], places: NDArray[np.int64], listed: NDArray[np.int64]) -> Keyed:
    """Return for each of the ``listed`` keys how many runs of consecutive places it has, and the runs.

    A run is its gap to the run before it, or to 0, and its length - 1.
    """
    order = np.lexsort((places, keys))
    keys, places = keys[order], places[order]
    opens = np.ones(len(keys), np.bool_)
    opens[1:] = (np.diff(keys) != 0) | (np.diff(places) != 1)
    starts = np.flatnonzero(opens)
    lengths = np.diff(starts, append=len(keys))
    owners, firsts = keys[starts], places[starts]
    ends = np.concatenate(([0], (firsts + lengths)[:-1])) if len(starts) else firsts
    ends[np.diff(owners, prepend=-1) != 0] = 0
    pairs = np.column_stack((firsts - ends, lengths - 1)).ravel()
    counts = np.searchsorted(owners, listed, side="right") - np.searchsorted(owners, listed, side="left")
    return Keyed(listed, counts).then(Keyed(np.repeat(owners, 2), pairs))


def text(data: bytes) -> str:
    """Return base64 text."""
    return base64.b64encode(data).decode("ascii")


def bits(mask: NDArray[np.bool_]) -> str:
    """Return a mask as base64, eight cells a byte, row by row, highest bit first."""
    return text(np.packbits(mask.ravel()).tobytes())


def shares(values: NDArray[np.float64]) -> str:
    """Return shares from 0 to 1 as base64 of little-endian 16-bit numbers."""
    return text(np.round(np.clip(values, 0, 1) * 65535).astype("<u2").tobytes())
