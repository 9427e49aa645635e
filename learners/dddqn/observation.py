"""What the network sees: 728 numbers around one UAV, computed from its own belief map alone.

``scene`` (696,) uint8, 255 standing for 1: a 15x15 fine map (unknown, known free), an 11x11 coarse map of
3x3 blocks (the same two), both centred on the UAV and zero off the map, and the unknown cells on each of
its four sides. ``moves`` (4, 8) float32: for each move what lies behind it, see :data:`MOVE_FEATURES`.

Everything is measured in lidar ranges: one fine pixel is one cell at range 3 and a block of 3x3 cells at
range 10, gains are shares of the lidar disc, and distances count in units of a third of the range. So the
input has the same size and about the same meaning for any map and lidar. Rotating or mirroring the world
only permutes the numbers (:mod:`indoor_explorers.learners.dddqn.symmetry`).
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.compiled import kernel, leaf
from indoor_explorers.env.grid import FREE, MOVES, UNKNOWN, distances_from, touches_unknown
from indoor_explorers.env.lidar import new_scan, unknown_in_view, visible_cells
from indoor_explorers.learners.dddqn.sensor import Scratch, Sensor

#: Pixels a side of the fine and of the coarse map.
FINE, COARSE = 15, 11
#: Length of ``scene``.
SCENE = 2 * FINE * FINE + 2 * COARSE * COARSE + 4
#: The eight numbers of each move, all from 0 to 1 save the sum, which may pass 1.
MOVE_FEATURES = (
    "blocked",
    "gain there",
    "distance to the nearest gain",
    "best gain ahead, discount .7",
    "best gain ahead, discount .85",
    "best gain ahead, discount .95",
    "sum of the gain ahead, discount .7",
    "visits since the last gain",
)
#: Visits beyond this many look the same.
VISIT_CAP = 4
#: Reference steps at which the distance feature is one half.
HALF_DISTANCE = 8.0


@kernel()
def remember(belief: np.ndarray, row: int, col: int, sensor: Sensor, noted: np.ndarray, visits: np.ndarray) -> int:
    """Count a visit of (row, col) in ``visits`` (H, W) uint8, forgetting all of them after a gain of its own.

    ``noted`` (H, W) uint8 marks the cells known at the last call and is brought up to date. Returns the gain:
    the newly known cells in view of the UAV. What it does not see came by radio, and says nothing about
    whether it is getting anywhere itself.
    """
    height, width = belief.shape
    scan = new_scan(sensor.optics)
    gain = 0
    for k in range(visible_cells(belief, row, col, sensor.optics, scan)):
        r, c = divmod(scan.cells[k], width)
        if belief[r, c] != UNKNOWN and noted[r, c] == 0:
            noted[r, c] = 1
            gain += 1
    for r in range(height):
        for c in range(width):
            noted[r, c] = belief[r, c] != UNKNOWN
    if gain > 0:
        visits[:] = 0
    visits[row, col] = min(visits[row, col] + 1, 255)
    return gain


@leaf()
def _tabulate(belief: np.ndarray, unknown: np.ndarray, free: np.ndarray) -> None:
    """Fill the summed-area tables (H + 1, W + 1) of unknown and of known free cells."""
    for r in range(belief.shape[0]):
        row_unknown = row_free = 0
        for c in range(belief.shape[1]):
            row_unknown += belief[r, c] == UNKNOWN
            row_free += belief[r, c] == FREE
            unknown[r + 1, c + 1] = unknown[r, c + 1] + row_unknown
            free[r + 1, c + 1] = free[r, c + 1] + row_free


@leaf()
def _within(table: np.ndarray, top: int, left: int, bottom: int, right: int) -> int:
    """Sum a summed-area table over rows top..bottom - 1 and columns left..right - 1, cut to the map."""
    height, width = table.shape[0] - 1, table.shape[1] - 1
    top, bottom = min(max(top, 0), height), min(max(bottom, 0), height)
    left, right = min(max(left, 0), width), min(max(right, 0), width)
    return int(table[bottom, right] - table[top, right] - table[bottom, left] + table[top, left])


@leaf()
def _pool(table: np.ndarray, row: int, col: int, pixels: int, side: int, out: np.ndarray) -> None:
    """Write the share of each of pixels x pixels blocks, ``side`` (odd) cells wide, centred on (row, col)."""
    first = -((pixels * side) // 2)
    for i in range(pixels):
        top = row + first + i * side
        for j in range(pixels):
            left = col + first + j * side
            count = _within(table, top, left, top + side, left + side)
            out[i * pixels + j] = (510 * count + side * side) // (2 * side * side)


@leaf()
def _look_around(row: int, col: int, sensor: Sensor, scratch: Scratch, out: np.ndarray) -> None:
    """Write ``scene``: the fine and coarse maps and the unknown cells down, left, up and right."""
    fine, coarse = FINE * FINE, COARSE * COARSE
    _pool(scratch.unknown, row, col, FINE, sensor.scale, out[:fine])
    _pool(scratch.free, row, col, FINE, sensor.scale, out[fine : 2 * fine])
    at = 2 * fine
    _pool(scratch.unknown, row, col, COARSE, 3 * sensor.scale, out[at : at + coarse])
    _pool(scratch.free, row, col, COARSE, 3 * sensor.scale, out[at + coarse : at + 2 * coarse])
    at += 2 * coarse
    height, width = scratch.gain.shape
    table = scratch.unknown
    sides = (
        _within(table, row + 1, 0, height, width),
        _within(table, 0, 0, height, col),
        _within(table, 0, 0, row, width),
        _within(table, 0, col + 1, height, width),
    )
    for k in range(4):
        out[at + k] = int(255.0 * sides[k] / (sides[k] + 4.0 * sensor.disc) + 0.5)


@leaf()
def _gain_at(belief: np.ndarray, row: int, col: int, sensor: Sensor, scratch: Scratch) -> int:
    reach = sensor.reach
    if _within(scratch.unknown, row - reach, col - reach, row + reach + 1, col + reach + 1) == 0:
        return 0
    return unknown_in_view(belief, row, col, sensor.optics, scratch.scan)


@leaf()
def _survey(belief: np.ndarray, row: int, col: int, sensor: Sensor, scratch: Scratch) -> int:
    """Fill ``gain`` at reachable places: a lattice around the UAV and every frontier cell.

    Returns the steps to the nearest gain, -1 when nothing within reach is unknown.
    """
    reached = distances_from(belief, row, col, scratch.queue, scratch.steps)
    width, nearest = belief.shape[1], -1
    for i in range(reached):
        r, c = divmod(scratch.queue[i], width)
        on_lattice = (r - row) % sensor.scale == 0 and (c - col) % sensor.scale == 0
        gain = 0
        if on_lattice or touches_unknown(belief, r, c):
            gain = _gain_at(belief, r, c, sensor, scratch)
        scratch.gain[r, c] = gain
        if gain > 0 and nearest < 0:
            nearest = scratch.steps[r, c]
    return nearest


@leaf()
def _look_ahead(
    belief: np.ndarray, row: int, col: int, move: int, sensor: Sensor, scratch: Scratch, out: np.ndarray
) -> None:
    """Write the distance to and the discounted gains of what can be reached after one move."""
    width = belief.shape[1]
    r0, c0 = row + MOVES[move, 0], col + MOVES[move, 1]
    reached = distances_from(belief, r0, c0, scratch.queue, scratch.steps)
    weight = (sensor.scale * sensor.rate) ** 2 / sensor.disc
    near, middle, far, total, nearest, at = 0.0, 0.0, 0.0, 0.0, -1, 0
    power = (1.0, 1.0, 1.0)
    for i in range(reached):
        r, c = divmod(scratch.queue[i], width)
        gain = scratch.gain[r, c]
        if gain == 0:
            continue
        while at < scratch.steps[r, c]:
            at += 1
            power = (power[0] * sensor.decay[0], power[1] * sensor.decay[1], power[2] * sensor.decay[2])
        if nearest < 0:
            nearest = at
        near, middle, far = max(near, gain * power[0]), max(middle, gain * power[1]), max(far, gain * power[2])
        if (r - row) % sensor.scale == 0 and (c - col) % sensor.scale == 0:
            total += gain * power[0] * weight
    distance = nearest * sensor.rate
    out[2] = distance / (distance + HALF_DISTANCE) if nearest >= 0 else 1.0
    out[3], out[4], out[5] = np.sqrt(near / sensor.disc), np.sqrt(middle / sensor.disc), np.sqrt(far / sensor.disc)
    out[6] = np.sqrt(total)


@leaf()
def observe(
    belief: np.ndarray,
    row: int,
    col: int,
    visits: np.ndarray,
    sensor: Sensor,
    scratch: Scratch,
    scene: np.ndarray,
    moves: np.ndarray,
) -> int:
    """Write the observation of a UAV at (row, col) with ``visits`` (H, W) since its last gain.

    Fills ``scene`` (696,) uint8 and ``moves`` (4, 8) float32. Returns the steps to the nearest place from
    which something unknown is in view, -1 when nothing within reach is unknown.
    """
    _tabulate(belief, scratch.unknown, scratch.free)
    _look_around(row, col, sensor, scratch, scene)
    nearest = _survey(belief, row, col, sensor, scratch)
    for k in range(4):
        r, c = row + MOVES[k, 0], col + MOVES[k, 1]
        moves[k] = 0.0
        if not (0 <= r < belief.shape[0] and 0 <= c < belief.shape[1] and belief[r, c] == FREE):
            moves[k, 0] = moves[k, 2] = 1.0
            continue
        moves[k, 1] = np.sqrt(_gain_at(belief, r, c, sensor, scratch) / sensor.disc)
        _look_ahead(belief, row, col, k, sensor, scratch, moves[k])
        moves[k, 7] = min(visits[r, c], VISIT_CAP) / VISIT_CAP
    return nearest


@kernel()
def observe_all(
    belief: np.ndarray,
    cell: np.ndarray,
    noted: np.ndarray,
    visits: np.ndarray,
    columns: np.ndarray,
    sensor: Sensor,
    scratch: Scratch,
    scene: np.ndarray,
    moves: np.ndarray,
) -> None:
    """Remember and observe for some ``columns`` (K,) of C UAVs on maps of one shape.

    ``belief``, ``noted`` and ``visits`` are (C, H, W) uint8, ``cell`` (C, 2); fills the columns of ``scene``
    (C, 696) and ``moves`` (C, 4, 8).
    """
    for i in columns:
        row, col = cell[i, 0], cell[i, 1]
        remember(belief[i], row, col, sensor, noted[i], visits[i])
        observe(belief[i], row, col, visits[i], sensor, scratch, scene[i], moves[i])
