"""The array types that cross module borders, named tuples of arrays, and arrays that can be read only."""

from __future__ import annotations

from functools import cache
from typing import Any, TypeAlias, TypeVar, get_args, get_type_hints

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
#: A named tuple of arrays.
ArrayTuple = TypeVar("ArrayTuple", bound=tuple[NDArray[Any], ...])


def allocated(kind: type[ArrayTuple], **sizes: int) -> ArrayTuple:
    """Return a named tuple of zeros; its fields are annotated like ``Annotated[NDArray[np.int64], "B N 2"]``.

    Args:
        kind: The class of the named tuple.
        **sizes: The length of each named axis; a number in an annotation is the length of its own axis.

    """
    return kind(*(np.zeros([sizes[n] if n in sizes else int(n) for n in axes], dtype) for dtype, axes in _fields(kind)))


@cache
def _fields(kind: type[Any]) -> list[tuple[type[np.generic], list[str]]]:
    """Return the type and the axes of each array of a named tuple."""
    annotated = [get_args(hint) for hint in get_type_hints(kind, include_extras=True).values()]
    return [(_scalar_type(array), axes.split()) for array, axes in annotated]


def _scalar_type(array: Any) -> type[np.generic]:
    """Return the innermost argument of an array type: the alias ``NDArray`` has other arguments since numpy 2.5."""
    while arguments := get_args(array):
        array = arguments[-1]
    scalar: type[np.generic] = array
    return scalar


def copied(arrays: ArrayTuple) -> ArrayTuple:
    """Return a named tuple with arrays of its own; an array that it has twice, its copy has twice."""
    copies = {id(array): array.copy() for array in arrays}
    return type(arrays)(*(copies[id(array)] for array in arrays))


#: The arrays whose memory is lent, by the id of their window; no window refers to its array.
_LENT: dict[int, NDArray[Any]] = {}


class _Window:
    """Lend the memory of an array to numpy read-only, without a reference to the array."""

    def __init__(self, array: NDArray[Any]) -> None:
        where, _ = array.__array_interface__["data"]
        self.__array_interface__ = array.__array_interface__ | {"data": (where, True), "strides": array.strides}
        _LENT[id(self)] = array  # keeps the memory alive as long as the window

    def __del__(self, lent: dict[int, NDArray[Any]] = _LENT) -> None:
        lent.pop(id(self), None)


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Return a live view of an array that cannot be made writeable and whose ``base`` is not the array.

    The flag of a plain numpy view can be set back, and its ``base`` is the whole array.
    """
    return np.asarray(_Window(array))
