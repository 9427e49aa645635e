"""Exact line of sight in three dimensions, on the plane of a volume (:mod:`indoor_explorers.env.grid.levels`).

The rules are those of :mod:`indoor_explorers.env.sensing.shadowcasting`, with faces for sides. A free cell is seen when
the segment between the two cell centres crosses no obstacle; an obstacle is seen when the segment from the sensor to
the midpoint of one of its faces, one that faces a cell that is no obstacle, crosses none. Where a segment passes
through an edge or a corner of cells, it crosses none if moves along one axis after the other lead past there through
cells that are no obstacles: touching one does not block, passing between two that touch does.

The segments are walked one by one, cell by cell as tables of the lidar say
(:mod:`indoor_explorers.env.sensing.volume_tables`), up to the first obstacle. A UAV that explores has seen most of the
cells around it before; these are left out, so a scan costs about as much as what it adds.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.cells import OCCUPIED
from indoor_explorers.env.grid.compiled import inner, leaf
from indoor_explorers.env.grid.levels import on_level, rise_of
from indoor_explorers.env.sensing.volume_tables import AXES, CENTRE, STEPS, VolumeTables


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


@inner()
def _crosses_none(cells: np.ndarray, origin: int, strides: tuple[int, int], number: int, tables: VolumeTables) -> bool:
    """Tell whether a segment, by its number in ``begins``, crosses no obstacle."""
    cell = origin
    for place in range(tables.begins[number], tables.begins[number + 1]):
        step = tables.steps[place]
        cell += STEPS[step, 0] * strides[0] + STEPS[step, 1] * strides[1] + STEPS[step, 2]
        if cells[cell] == OCCUPIED or (AXES[step] > 1 and not _slips_by(cells, cell, step, strides)):
            return False
    return True


@inner()
def _is_seen(
    cells: np.ndarray,
    origin: int,
    cell: int,
    towards: tuple[int, int, int],
    strides: tuple[int, int],
    number: int,
    tables: VolumeTables,
) -> bool:
    """Tell whether a flat ``cell`` is seen, its segments in ``begins`` from ``number`` on.

    ``towards`` are the differences to the cells behind its faces that face the sensor, 0 for faces that do not.
    """
    if cells[cell] != OCCUPIED:
        return _crosses_none(cells, origin, strides, number + CENTRE, tables)
    return bool(
        (cells[cell - towards[0]] != OCCUPIED and _crosses_none(cells, origin, strides, number, tables))
        or (cells[cell - towards[1]] != OCCUPIED and _crosses_none(cells, origin, strides, number + 1, tables))
        or (cells[cell - towards[2]] != OCCUPIED and _crosses_none(cells, origin, strides, number + 2, tables))
    )


@leaf(entry=False)
def scan_volume(
    occupancy: np.ndarray, known: np.ndarray, row: int, col: int, tables: VolumeTables, out: np.ndarray
) -> int:
    """Fill ``out`` with the flat indices of the cells seen from (row, col) of a plane; return how many.

    In ``occupancy`` (H, W) uint8, the plane of a volume, only ``OCCUPIED`` blocks. Cells that are not 0 in ``known``
    (H, W) uint8 are left out, except for the own one; an array of no cells leaves out none. The own cell comes first,
    and each once.
    """
    cells, marks = occupancy.reshape(occupancy.size), known.reshape(known.size)
    width, rise = occupancy.shape[1], rise_of(occupancy.shape[0], tables.levels)
    strides, (level, on_row) = (rise * width, width), on_level(row, rise)
    origin, seen = row * width + col, 1
    out[0] = origin
    for k in range(tables.spans.shape[0]):
        up, down, begin, end, number = tables.spans[k]
        if not (0 <= level + up < tables.levels and 0 <= on_row + down < rise - 1):
            continue
        base = origin + up * strides[0] + down * strides[1]
        for across in range(max(begin, -col), min(end, width - col)):
            cell = base + across
            if marks.size > 0 and marks[cell] != 0:
                continue
            towards = np.sign(up) * strides[0], np.sign(down) * strides[1], np.sign(across)
            if _is_seen(cells, origin, cell, towards, strides, 4 * (number + across - begin), tables):
                out[seen] = cell
                seen += 1
    return seen
