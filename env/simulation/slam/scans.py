"""A scan of a lidar with errors, compiled.

The lidar scans a distorted map, drawn anew for every scan: each free cell is an obstacle with the probability of a
false return, each obstacle is transparent with that of a miss. Obstacles are then read nearer or farther along their
ray, by a normal error. Beyond the eight neighbours, which proximity sensors cover, only cells in the field of view are
read. Draws depend on seed, agent, scan and cell alone, so a scan can be repeated when maps are drawn again after a
correction.
"""

from __future__ import annotations

from math import cos, floor, log, pi, sqrt

import numpy as np

from indoor_explorers.env.grid.cells import FREE, MOVES, OCCUPIED
from indoor_explorers.env.grid.compiled import inner, leaf
from indoor_explorers.env.grid.randomness import draw, uniform
from indoor_explorers.env.sensing.field_of_view import is_in_view
from indoor_explorers.env.sensing.inverse_model import CERTAIN, HIT, PASS
from indoor_explorers.env.sensing.lidar import visible_cells
from indoor_explorers.env.simulation.slam.state import ErrorRules, Readings, Slam, SlamParts
from indoor_explorers.env.simulation.state import State

#: Streams of one scan: distortion, and the two numbers of a normal error.
DISTORTION, ERROR, ANGLE, KINDS = 0, 1, 2, 3


@inner()
def _scan_key(state: State, slam: Slam, b: int, agent: int, scan: int, kind: int) -> np.uint64:
    return draw(slam.noise_key[b], np.uint64((scan * state.end.shape[1] + agent) * KINDS + kind))


@inner()
def _distort(
    rules: ErrorRules, truth: np.ndarray, key: np.uint64, row: int, col: int, reach: int, out: np.ndarray
) -> None:
    """Draw the distorted map (H, W) of a lidar in (row, col), up to ``reach`` cells around."""
    height, width = truth.shape
    for r in range(max(0, row - reach), min(height, row + reach + 1)):
        for c in range(max(0, col - reach), min(width, col + reach + 1)):
            chance = rules.false_returns if truth[r, c] == FREE else rules.misses
            errs = chance > 0.0 and uniform(key, r * width + c) < chance
            out[r, c] = (OCCUPIED if truth[r, c] == FREE else FREE) if errs else truth[r, c]
    out[row, col] = FREE


@inner()
def _note(readings: Readings, count: int, cell: int, value: np.float32) -> int:
    """Enter the reading of a cell; an obstacle counts more than free space. Returns the number of cells read."""
    place = readings.place[cell]
    if place == 0:
        readings.cells[count], readings.values[count] = cell, value
        readings.place[cell] = count + 1
        return count + 1
    readings.values[place - 1] = max(readings.values[place - 1], value)
    return count


@inner()
def _note_obstacle(
    rules: ErrorRules,
    readings: Readings,
    count: int,
    keys: tuple[np.uint64, np.uint64],
    own: int,
    cell: int,
    shape: tuple[int, int],
) -> int:
    """Enter an obstacle seen from the flat cell ``own``, nearer or farther by an error with the two ``keys``."""
    height, width = shape
    row, col = own // width, own % width
    rows, cols = cell // width - row, cell % width - col
    distance = sqrt(rows * rows + cols * cols)
    spread = sqrt(-2.0 * log(1.0 - uniform(keys[0], cell))) * cos(2.0 * pi * uniform(keys[1], cell))
    read = max(1.0, distance + rules.range_std * spread)
    r, c = row + floor(rows * read / distance + 0.5), col + floor(cols * read / distance + 0.5)
    target = r * width + c
    inside = 0 <= r < height and 0 <= c < width
    if read > distance and (not inside or target != cell):
        count = _note(readings, count, cell, PASS)
    return _note(readings, count, target, HIT) if inside else count


@leaf(entry=False)
def read_scan(parts: SlamParts, b: int, agent: int, number: int) -> int:
    """Repeat a scan of an agent: fill ``readings`` and return how many cells it read; the own one comes first."""
    rules, state, slam, lidar, readings = parts.errors, parts.state, parts.slam, parts.lidar, parts.readings
    height, width = state.truth.shape[1], state.truth.shape[2]
    own, heading = int(slam.true_cell[b, agent, number]), int(slam.heading[b, agent, number])
    row, col = own // width, own % width
    occupancy = state.truth[b]
    if rules.misses > 0.0 or rules.false_returns > 0.0:
        key = _scan_key(state, slam, b, agent, number, DISTORTION)
        _distort(rules, state.truth[b], key, row, col, lidar.half_widths.shape[0], readings.occupancy)
        occupancy = readings.occupancy
    keys = (_scan_key(state, slam, b, agent, number, ERROR), _scan_key(state, slam, b, agent, number, ANGLE))
    count = _note(readings, 0, own, CERTAIN * PASS)
    for k in range(1, visible_cells(occupancy, row, col, lidar, parts.work.scan)):
        cell = parts.work.scan.cells[k]
        r, c = cell // width, cell % width
        if cell == own or not is_in_view(rules.least_cosine, heading, r - row, c - col):
            continue
        if occupancy[r, c] != OCCUPIED:
            count = _note(readings, count, cell, PASS)
        elif rules.range_std > 0.0:
            count = _note_obstacle(rules, readings, count, keys, own, cell, (height, width))
        else:
            count = _note(readings, count, cell, HIT)
    bump = slam.bump[b, agent, number]
    if bump >= 0:
        r, c = row + MOVES[bump, 0], col + MOVES[bump, 1]
        if 0 <= r < height and 0 <= c < width:
            count = _note(readings, count, r * width + c, CERTAIN * HIT)
    for k in range(count):
        readings.place[readings.cells[k]] = 0
    return count
