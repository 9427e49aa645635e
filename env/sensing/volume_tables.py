"""The tables of a lidar over several levels: where the segments to all cells in range lead.

They are made once for a lidar, by arithmetic on integers alone: coordinates are doubled, so that borders of cells are
odd, and crossings are compared by cross-multiplication.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.compiled import inner, kernel

#: The number of a cell's centre, after those of its three faces.
CENTRE = 3
#: The most cells around a lidar, whose tables take some 250 MB.
MOST_AROUND = 1_000_000
#: (27, 3) the steps of a segment from cell to cell, each -1, 0 or 1 levels, rows and columns, and along how many axes.
STEPS = np.stack(np.meshgrid(*3 * [np.arange(-1, 2)], indexing="ij"), axis=-1).reshape(27, 3)
AXES = np.abs(STEPS).sum(axis=1)


class VolumeTables(NamedTuple):
    """What a lidar over several levels can see, relative to its cell; all are empty for one level."""

    levels: int
    """L, the levels of the map; 0 for a lidar that sees only its own level."""
    spans: NDArray[np.int32]
    """(S, 5) the M cells in range as runs along the columns: levels, rows, first column, column after the last one, and
    the number of the first one."""
    begins: NDArray[np.int32]
    """(4 M + 1,) where the steps begin that lead to each cell in range: first those to its face towards the sensor
    along the levels, then along the rows, then along the columns, then to its centre. Faces that there are not have
    no steps."""
    steps: NDArray[np.int8]
    """The steps, of :data:`STEPS`."""


@inner()
def _next_step(
    to: tuple[int, int, int], until: tuple[int, int, int], done: tuple[int, int, int]
) -> tuple[int, int, int]:
    """Return by how much a segment's next crossing of a border changes level, row and column, each 0 or 1.

    The segment leads by ``to`` half cells along each axis, none negative; the ``done`` crossings of the ``until`` ones
    are behind. The next one along an axis is (2 done + 1) / to of the way.
    """
    past, way = 1, 0  # as a fraction, infinitely far
    for axis in range(3):
        if done[axis] < until[axis] and (2 * done[axis] + 1) * way < past * to[axis]:
            past, way = 2 * done[axis] + 1, to[axis]
    return (
        int(done[0] < until[0] and (2 * done[0] + 1) * way == past * to[0]),
        int(done[1] < until[1] and (2 * done[1] + 1) * way == past * to[1]),
        int(done[2] < until[2] and (2 * done[2] + 1) * way == past * to[2]),
    )


@kernel(entry=False)
def _steps_to(offset: np.ndarray, face: int, out: np.ndarray) -> int:
    """Fill ``out`` with the steps of the segment to a cell's centre, or to its ``face`` 0 to 2; return how many.

    ``offset`` is (3,); ``face`` is the axis towards whose border the segment leads, or :data:`CENTRE`.
    """
    size, sign = np.abs(offset), np.sign(offset)
    to = 2 * size[0] - (face == 0), 2 * size[1] - (face == 1), 2 * size[2] - (face == 2)
    until = size[0] - (face == 0), size[1] - (face == 1), size[2] - (face == 2)
    done, count = (0, 0, 0), 0
    while done[0] < until[0] or done[1] < until[1] or done[2] < until[2]:
        step = _next_step(to, until, done)
        done = done[0] + step[0], done[1] + step[1], done[2] + step[2]
        out[count] = 13 + 9 * step[0] * sign[0] + 3 * step[1] * sign[1] + step[2] * sign[2]
        count += 1
    return count


@kernel()
def _list_steps(offsets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return ``begins`` and ``steps`` of :class:`VolumeTables` for (M, 3) offsets."""
    begins, longest = np.zeros(4 * offsets.shape[0] + 1, np.int32), 3 * np.max(np.abs(offsets)) + 1
    steps, count = np.empty(64 * longest, np.int8), 0
    for k in range(offsets.shape[0]):
        for face in range(4):
            if count + longest > steps.shape[0]:
                steps = np.concatenate((steps, np.empty_like(steps)))
            if face == CENTRE or offsets[k, face] != 0:
                count += _steps_to(offsets[k], face, steps[count:])
            begins[4 * k + face + 1] = count
    return begins, steps[:count].copy()


def offsets_in_range(reach: float, levels: int, elevation: float) -> NDArray[np.int64]:
    """Return the (M, 3) offsets of the cells that a lidar covers, in levels, rows and columns, without its own.

    They are at most ``reach`` cells away, up to ``levels`` - 1 levels, and at most ``elevation`` degrees up or down;
    the 26 cells around the sensor are always covered.

    Raises:
        InputError: there are too many.

    """
    most, high = int(reach + 1e-9), min(int(reach + 1e-9), levels - 1)
    if (count := (2 * high + 1) * (2 * most + 1) ** 2) > MOST_AROUND:
        raise InputError(
            f"expected at most {MOST_AROUND:,} cells around a lidar, got {count:,} with range {reach} and {levels} "
            "levels; shorten lidar.range"
        )
    axes = (np.arange(-high, high + 1), np.arange(-most, most + 1), np.arange(-most, most + 1))
    offsets = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    squared, flat = (offsets**2).sum(axis=1), (offsets[:, 1:] ** 2).sum(axis=1)
    around = np.abs(offsets).max(axis=1) <= 1
    level = np.abs(offsets[:, 0]) <= np.tan(np.radians(min(elevation, 89.0))) * np.sqrt(flat) + 1e-9
    covered = (squared <= reach**2 + 1e-9) & (level | around | (elevation >= 90.0))
    return np.ascontiguousarray(offsets[covered & (squared > 0)], np.int64)


def volume_tables(reach: float, levels: int, elevation: float) -> VolumeTables:
    """Return the tables of a lidar over ``levels`` levels; its range and elevation as in :func:`offsets_in_range`."""
    if levels < 2:
        return VolumeTables(0, np.empty((0, 5), np.int32), np.empty(0, np.int32), np.empty(0, np.int8))
    offsets = offsets_in_range(reach, levels, elevation)
    begins, steps = _list_steps(offsets)
    first = np.flatnonzero(np.r_[True, (np.diff(offsets, axis=0) != (0, 0, 1)).any(axis=1)])
    after = np.r_[first[1:], len(offsets)]
    spans = np.column_stack((offsets[first], offsets[after - 1, 2] + 1, first)).astype(np.int32)
    return VolumeTables(levels, spans, np.asarray(begins), np.asarray(steps))
