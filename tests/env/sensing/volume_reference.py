"""A slow lidar in three dimensions, independent of the compiled one: segments cut at borders in rational arithmetic."""

from fractions import Fraction
from itertools import permutations

import numpy as np

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN


def borders(start, end):
    """Times in (0, 1) at which a coordinate in half cells is on an odd number, where cells meet."""
    if start == end:
        return []
    low, high = sorted((start, end))
    return [t for y in range(low - 3, high + 4) if y % 2 and 0 < (t := Fraction(y - start, end - start)) < 1]


def cell_at(start, end, time):
    """The cell of the point of a segment at a time at which it is on no border."""
    return tuple(int((s + time * (e - s) + 1) // 2) for s, e in zip(start, end, strict=True))


def crosses(volume, start, end):
    """Whether a segment between two points in half cells runs through an obstacle, or between some that touch."""
    moments = [borders(s, e) for s, e in zip(start, end, strict=True)]
    times = sorted(set().union(*moments))
    middles = [(a + b) / 2 for a, b in zip([Fraction(0), *times], [*times, Fraction(1)], strict=True)]
    cells = [cell_at(start, end, time) for time in middles]
    if any(volume[cell] == OCCUPIED for cell in cells):
        return True
    for time, before in zip(times, cells, strict=False):
        axes = [axis for axis in range(3) if time in moments[axis]]
        ways = []
        for order in permutations(axes):
            cell, way = list(before), []
            for axis in order:
                cell[axis] += 1 if end[axis] > start[axis] else -1
                way.append(volume[tuple(cell)] != OCCUPIED)
            ways.append(all(way))
        if not any(ways):
            return True
    return False


def reference_volume_scan(volume, voxel, lidar_range):
    """The rules of the docstring, one cell at a time."""
    belief, here = np.full(volume.shape, UNKNOWN), tuple(2 * place for place in voxel)
    for other in np.ndindex(volume.shape):
        if sum((a - b) ** 2 for a, b in zip(voxel, other, strict=True)) > Fraction(lidar_range) ** 2:
            continue
        there = tuple(2 * place for place in other)
        if volume[other] == FREE:
            if not crosses(volume, here, there):
                belief[other] = FREE
            continue
        for axis in range(3):
            for side in (-1, 1):
                facing = tuple(place + side * (axis == k) for k, place in enumerate(other))
                inside = all(0 <= place < length for place, length in zip(facing, volume.shape, strict=True))
                face = tuple(place + side * (axis == k) for k, place in enumerate(there))
                if inside and volume[facing] != OCCUPIED and not crosses(volume, here, face):
                    belief[other] = OCCUPIED
    return belief
