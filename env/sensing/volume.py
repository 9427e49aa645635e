"""Exact line of sight in three dimensions, on the plane of a volume (:mod:`indoor_explorers.env.grid.levels`).

The rules are those of :mod:`indoor_explorers.env.sensing.shadowcasting`, with faces for sides. A free cell is seen when
the segment between the two cell centres crosses no obstacle; an obstacle is seen when the segment from the sensor to
the midpoint of one of its faces, one that faces a cell that is no obstacle, crosses none. Where a segment passes
through an edge or a corner of cells, it crosses none if moves along one axis after the other lead past there through
cells that are no obstacles: touching one does not block, passing between two that touch does.

The segments to all cells in range are a tree of cells, since many begin alike. A scan walks the tree and leaves out
what is behind an obstacle, so it costs about as much as what is seen. Obstacles are few; the segments to their faces
are walked one by one (:mod:`indoor_explorers.env.sensing.volume_tables`).
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.cells import OCCUPIED
from indoor_explorers.env.grid.compiled import inner, leaf
from indoor_explorers.env.grid.levels import on_level, rise_of
from indoor_explorers.env.sensing.volume_tables import AXES, BEHIND, COL, ENDS, LEVEL, ROW, STEP, STEPS, VolumeTables


@leaf(entry=False)
def _slips_by(cells: np.ndarray, cell: int, step: int, strides: tuple[int, int]) -> bool:
    """Tell whether a step along two or three axes into a flat ``cell`` leads past obstacles that touch each other."""
    up, down, right = STEPS[step, 0] * strides[0], STEPS[step, 1] * strides[1], STEPS[step, 2]
    before = cell - up - down - right
    if AXES[step] == 2:
        first, second = (up if up != 0 else down), (right if right != 0 else down)
        return bool(cells[before + first] != OCCUPIED or cells[before + second] != OCCUPIED)
    same_level, same_row, same_col = (  # after two of three moves
        cells[before + down + right] != OCCUPIED,
        cells[before + up + right] != OCCUPIED,
        cells[before + up + down] != OCCUPIED,
    )
    return bool(
        ((same_row or same_col) and cells[before + up] != OCCUPIED)
        or ((same_level or same_col) and cells[before + down] != OCCUPIED)
        or ((same_level or same_row) and cells[before + right] != OCCUPIED)
    )


@leaf(entry=False)
def _add_free(
    cells: np.ndarray, size: tuple[int, int, int], at: tuple[int, int, int], tree: np.ndarray, out: np.ndarray
) -> int:
    """Fill ``out`` with the flat cells that are no obstacles and seen from the voxel ``at``; return how many."""
    strides = (size[1] + 1) * size[2], size[2]
    origin = at[0] * strides[0] + at[1] * strides[1] + at[2]
    out[0] = origin
    seen, place = 1, 0
    while place < tree.shape[0]:
        level, row, col = tree[place, LEVEL], tree[place, ROW], tree[place, COL]
        cell, step = origin + level * strides[0] + row * strides[1] + col, tree[place, STEP]
        if (
            0 <= at[0] + level < size[0]
            and 0 <= at[1] + row < size[1]
            and 0 <= at[2] + col < size[2]
            and cells[cell] != OCCUPIED
            and (AXES[step] == 1 or _slips_by(cells, cell, step, strides))
        ):
            out[seen] = cell
            seen += tree[place, ENDS]
            place += 1
        else:
            place = tree[place, BEHIND]
    return seen


@inner()
def _shows(cells: np.ndarray, origin: int, strides: tuple[int, int], number: int, tables: VolumeTables) -> bool:
    """Tell whether the segment to a face, by its number in ``begins``, crosses no obstacle."""
    cell = origin
    for place in range(tables.begins[number], tables.begins[number + 1]):
        step = tables.steps[place]
        cell += STEPS[step, 0] * strides[0] + STEPS[step, 1] * strides[1] + STEPS[step, 2]
        if cells[cell] == OCCUPIED or (AXES[step] > 1 and not _slips_by(cells, cell, step, strides)):
            return False
    return True


@leaf(entry=False)
def _add_obstacles(
    cells: np.ndarray,
    size: tuple[int, int, int],
    at: tuple[int, int, int],
    tables: VolumeTables,
    out: np.ndarray,
    seen: int,
) -> int:
    """Append the flat obstacles that are seen from the voxel ``at`` to ``out``; return the new number of entries."""
    strides = (size[1] + 1) * size[2], size[2]
    origin = at[0] * strides[0] + at[1] * strides[1] + at[2]
    for k in range(tables.spans.shape[0]):
        level, row, begin, end, number = tables.spans[k]
        if not (0 <= at[0] + level < size[0] and 0 <= at[1] + row < size[1]):
            continue
        base = origin + level * strides[0] + row * strides[1]
        up, down = np.sign(level) * strides[0], np.sign(row) * strides[1]
        for col in range(max(begin, -at[2]), min(end, size[2] - at[2])):
            cell, face = base + col, 3 * (number + col - begin)
            if cells[cell] == OCCUPIED and (
                (cells[cell - up] != OCCUPIED and _shows(cells, origin, strides, face, tables))
                or (cells[cell - down] != OCCUPIED and _shows(cells, origin, strides, face + 1, tables))
                or (cells[cell - np.sign(col)] != OCCUPIED and _shows(cells, origin, strides, face + 2, tables))
            ):
                out[seen] = cell
                seen += 1
    return seen


@leaf(entry=False)
def scan_volume(occupancy: np.ndarray, row: int, col: int, tables: VolumeTables, out: np.ndarray) -> int:
    """Fill ``out`` with the flat indices of the cells seen from (row, col) of a plane; return how many.

    In ``occupancy`` (H, W) uint8, the plane of a volume, only ``OCCUPIED`` blocks. The own cell comes first, then those
    that are no obstacles, and each once.
    """
    cells, rise = occupancy.reshape(occupancy.size), rise_of(occupancy.shape[0], tables.levels)
    size, at = (tables.levels, rise - 1, occupancy.shape[1]), (*on_level(row, rise), col)
    return _add_obstacles(cells, size, at, tables, out, _add_free(cells, size, at, tables.tree, out))
