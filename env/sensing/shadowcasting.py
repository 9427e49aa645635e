"""Exact line of sight on a grid: the open directions of a quadrant, scanned outwards row by row.

A free cell is seen when the segment between the two cell centres crosses no obstacle; an obstacle cell is
seen when the segment from the sensor to the midpoint of one of its sides that faces a free cell crosses
none. Touching the corner of one obstacle does not block, passing between two that touch at a corner does.

Around the sensor are four quadrants, |across| <= along. In each, directions are slopes across / along, and the
directions that are still open after the obstacles of some rows are a list of closed arcs of slopes. A sight line to a
cell of row d can only be crossed by obstacles of earlier rows (as in symmetric shadowcasting,
https://www.albertford.com/shadowcasting/), so a row needs only the arcs, and a scan costs about as much as the cells in
view. All arithmetic is on integers: coordinates are doubled, so that cell borders are odd, and slopes are compared by
cross-multiplication. An arc may be a single slope: a sight line that touches the corners of obstacles on both sides.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.cells import OCCUPIED
from indoor_explorers.env.grid.compiled import inner, leaf


class Arc(NamedTuple):
    """The slopes from p / q to to_p / to_q, both included, and the cells of a row between them."""

    p: int
    q: int
    low: int
    """The first cell of the row whose centre is not before the arc."""
    to_p: int
    to_q: int
    high: int
    """The last cell of the row whose centre is not behind the arc."""


class Quadrant(NamedTuple):
    """One quadrant in a flat map: the cell (along, across) is ``origin + along * a + across * b``."""

    origin: int
    """Flat index of the sensor's cell."""
    along: int
    """Index step of one row away from the sensor."""
    across: int
    """Index step of one cell along such a row."""
    rows: int
    """Rows that the map has in this direction."""
    low: int
    """The leftmost cell that the map has in a row, 0 or less."""
    high: int
    """The rightmost one, 0 or more."""
    with_diagonals: bool
    """Whether this quadrant lists the free cells that it shares with its neighbours."""


@inner()
def _in_row(arcs: np.ndarray, k: int, d: int) -> Arc:
    """Return arc ``k``, which was left in a row before, as it is in row ``d``."""
    p, q, low, to_p, to_q, high = arcs[k, 0], arcs[k, 1], arcs[k, 2], arcs[k, 3], arcs[k, 4], arcs[k, 5]
    while low * q < p * d:
        low += 1
    while (low - 1) * q >= p * d:
        low -= 1
    while high * to_q > to_p * d:
        high -= 1
    while (high + 1) * to_q <= to_p * d:
        high += 1
    return Arc(p, q, low, to_p, to_q, high)


@inner()
def _first(arc: Arc, d: int) -> int:
    """Return the first cell of row ``d`` that the arc crosses."""
    before = arc.low - 1
    beyond = (2 * before + 1) * arc.q > arc.p * (2 * d - 1 if before >= 0 else 2 * d + 1)
    return before if beyond else arc.low


@inner()
def _last(arc: Arc, d: int) -> int:
    """Return the last cell of row ``d`` that the arc crosses."""
    behind = arc.high + 1
    within = (2 * behind - 1) * arc.to_q < arc.to_p * (2 * d - 1 if behind <= 0 else 2 * d + 1)
    return behind if within else arc.high


@leaf(entry=False)
def _is_squeezed(cells: np.ndarray, quadrant: Quadrant, p: int, q: int, d: int) -> bool:
    """Tell whether the slope p / q enters row ``d`` at a corner, between two obstacles that touch there."""
    lateral = p * (2 * d - 1)
    if lateral % q != 0:
        return False
    right = (lateral // q + 1) // 2  # the cells right - 1 and right meet at that corner
    if right - 1 < quadrant.low or right > quadrant.high:
        return False
    here, before = (right - 1, right) if p > 0 else (right, right - 1)
    row = quadrant.origin + d * quadrant.along
    return bool(
        cells[row + here * quadrant.across] == OCCUPIED
        and cells[row - quadrant.along + before * quadrant.across] == OCCUPIED
    )


@inner()
def _keep(cells: np.ndarray, quadrant: Quadrant, d: int, arc: Arc, arcs: np.ndarray, kept: int) -> int:
    """Append an arc to ``arcs``, unless it is empty or one squeezed slope; return how many there are."""
    wide = arc.to_p * arc.q - arc.p * arc.to_q
    if wide < 0 or (wide == 0 and _is_squeezed(cells, quadrant, arc.p, arc.q, d)):
        return kept
    arcs[kept, 0], arcs[kept, 1], arcs[kept, 2] = arc.p, arc.q, arc.low
    arcs[kept, 3], arcs[kept, 4], arcs[kept, 5] = arc.to_p, arc.to_q, arc.high
    return kept + 1


@inner()
def _shows_free(cells: np.ndarray, quadrant: Quadrant, arc: Arc, c: int, d: int) -> bool:
    """Tell whether the arc shows the centre of the free cell ``c`` of row ``d``."""
    if c < arc.low or c > arc.high:
        return False
    if abs(c) < d:
        return True
    return quadrant.with_diagonals and not _is_squeezed(cells, quadrant, 1 if c > 0 else -1, 1, d)


@inner()
def _shows_obstacle(cells: np.ndarray, quadrant: Quadrant, arc: Arc, c: int, d: int) -> bool:
    """Tell whether the arc shows the middle of a side of the obstacle ``c`` of row ``d``."""
    near = 2 * d - 1
    if abs(c) < d and arc.p * near <= 2 * c * arc.q and 2 * c * arc.to_q <= arc.to_p * near:
        return True
    inner = 1 if c > 0 else -1
    if c == 0 or cells[quadrant.origin + d * quadrant.along + (c - inner) * quadrant.across] == OCCUPIED:
        return False
    side = 2 * c - inner
    return bool(arc.p * 2 * d <= side * arc.q and side * arc.to_q <= arc.to_p * 2 * d)


@leaf(entry=False)
def scan_quadrant(
    cells: np.ndarray, quadrant: Quadrant, half_widths: np.ndarray, arcs: np.ndarray, out: np.ndarray, seen: int
) -> int:
    """Append the flat indices of the cells seen in one quadrant to ``out``; return the new number of entries.

    In ``cells`` (H*W,) uint8 only ``OCCUPIED`` blocks. ``half_widths`` (R + 1,) says how many cells to each
    side are in range in row d. ``arcs`` (2 K, 6) is scratch. An obstacle may be listed twice.
    """
    half = arcs.shape[0] // 2
    begin, end = 0, _keep(cells, quadrant, 0, Arc(-1, 1, 0, 1, 1, 0), arcs, 0)
    for d in range(1, min(quadrant.rows, half_widths.shape[0] - 1) + 1):
        reach, row = half_widths[d], quadrant.origin + d * quadrant.along
        widest = min(d, reach + 1)  # what lies beyond is out of range, and so are the shadows that it casts
        lowest, highest, kept = max(quadrant.low, -widest), min(quadrant.high, widest), half - begin
        for k in range(begin, end):
            arc = _in_row(arcs, k, d)
            if arc.p * arc.to_q == arc.to_p * arc.q and _is_squeezed(cells, quadrant, arc.p, arc.q, d):
                continue
            p, q, low = arc.p, arc.q, arc.low
            for c in range(max(lowest, _first(arc, d)), min(highest, _last(arc, d)) + 1):
                cell = row + c * quadrant.across
                if cells[cell] == OCCUPIED:
                    shown = _shows_obstacle(cells, quadrant, arc, c, d)
                    ends_at = 2 * d + 1 if c > 0 else 2 * d - 1
                    kept = _keep(cells, quadrant, d, Arc(p, q, low, 2 * c - 1, ends_at, c), arcs, kept)
                    p, q, low = 2 * c + 1, 2 * d - 1 if c >= 0 else 2 * d + 1, c
                else:
                    shown = _shows_free(cells, quadrant, arc, c, d)
                if shown and abs(c) <= reach:
                    out[seen] = cell
                    seen += 1
            kept = _keep(cells, quadrant, d, Arc(p, q, low, arc.to_p, arc.to_q, arc.high), arcs, kept)
        begin, end = half - begin, kept
    return seen
