"""The array types that cross module borders: their names, and arrays that can be read only."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

#: (H, W) uint8: 0 unknown, 1 free, 2 occupied.
Belief: TypeAlias = NDArray[np.uint8]
#: (H, W) bool.
Mask: TypeAlias = NDArray[np.bool_]
#: (H, W) int32, steps.
Distances: TypeAlias = NDArray[np.int32]
#: (row, column).
Cell: TypeAlias = tuple[int, int]


#: The arrays whose memory is lent, by the number of their window; no window refers to its array.
_LENT: dict[int, NDArray[Any]] = {}


class _Window:
    """Lend the memory of an array to numpy, which finds no way from here to the array or to write to it."""

    def __init__(self, array: NDArray[Any]) -> None:
        where, _ = array.__array_interface__["data"]
        self.__array_interface__ = array.__array_interface__ | {"data": (where, True), "strides": array.strides}
        _LENT[id(self)] = array  # keeps the memory for as long as it is looked at

    def __del__(self, lent: dict[int, NDArray[Any]] = _LENT) -> None:
        lent.pop(id(self), None)


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Return a live view of an array that cannot be made writeable again, nor can anything made from it.

    A plain view of numpy's could: its flag can be set back, and its ``base`` is the array itself. Give a slice to show
    no more than that.
    """
    return np.asarray(_Window(array))
