"""The map image, called ``scene`` in arrays: maps around one UAV, as pixels of 0 to 255.

A pixel of the fine map is one cell at lidar range 3, and 3x3 cells at range 10; a pixel of the coarse map is a block of
3x3 fine pixels. Both maps are centred on the UAV and zero off the map.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.cells import FREE, UNKNOWN, UNREACHABLE
from indoor_explorers.env.grid.compiled import leaf
from indoor_explorers.env.search.bfs import flood
from indoor_explorers.env.search.frontiers import touches_unknown
from indoor_explorers.learners.dddqn.observation.layout import IDENTITIES, ObservationLayout
from indoor_explorers.learners.dddqn.observation.scales import Scratch, Sensor
from indoor_explorers.learners.dddqn.observation.uav import Uav

#: Indices of the layers in :data:`indoor_explorers.learners.dddqn.observation.config.LAYERS`.
_UNKNOWN, _FREE, _CHANCE, _VISITS, _FRONTIER, _DISTANCE, _MATES, _MATES_PAST = range(8)
#: Largest number of visits that is shown.
VISIT_CAP = 4
#: Distance or waiting time, in steps at the reference range, that is shown as one half.
HALF_DISTANCE = 8.0
#: Factor on a teammate's brightness for each step, at the reference range, since it was heard.
FADING = 0.95


@leaf(entry=False)
def tabulate(belief: np.ndarray, unknown: np.ndarray, free: np.ndarray) -> None:
    """Fill the summed-area tables (H + 1, W + 1) of unknown and of known free cells."""
    for r in range(belief.shape[0]):
        row_unknown = row_free = 0
        for c in range(belief.shape[1]):
            row_unknown += belief[r, c] == UNKNOWN
            row_free += belief[r, c] == FREE
            unknown[r + 1, c + 1] = unknown[r, c + 1] + row_unknown
            free[r + 1, c + 1] = free[r, c + 1] + row_free


@leaf(entry=False)
def within(table: np.ndarray, top: int, left: int, bottom: int, right: int) -> int:
    """Return the sum over rows top..bottom - 1 and columns left..right - 1, clipped to the map.

    ``table`` (H + 1, W + 1) is the summed-area table.
    """
    height, width = table.shape[0] - 1, table.shape[1] - 1
    top, bottom = min(max(top, 0), height), min(max(bottom, 0), height)
    left, right = min(max(left, 0), width), min(max(right, 0), width)
    return int(table[bottom, right] - table[top, right] - table[bottom, left] + table[top, left])


@leaf(entry=False)
def _pool(table: np.ndarray, row: int, col: int, pixels: int, side: int, out: np.ndarray) -> None:
    """Write the mean of a table over each of pixels x pixels blocks, ``side`` (odd) cells wide, around (row, col)."""
    first = -((pixels * side) // 2)
    for i in range(pixels):
        top = row + first + i * side
        for j in range(pixels):
            left = col + first + j * side
            count = within(table, top, left, top + side, left + side)
            out[i * pixels + j] = (510 * count + side * side) // (2 * side * side)


@leaf(entry=False)
def _pool_layer(layer: np.ndarray, row: int, col: int, pixels: int, side: int, mean: bool, out: np.ndarray) -> None:
    """Write the mean or the maximum of a layer (H, W) over each of pixels x pixels blocks around (row, col)."""
    height, width = layer.shape
    first = -((pixels * side) // 2)
    for i in range(pixels):
        top = row + first + i * side
        for j in range(pixels):
            left, total, greatest = col + first + j * side, 0, 0
            for r in range(max(top, 0), min(top + side, height)):
                for c in range(max(left, 0), min(left + side, width)):
                    total += layer[r, c]
                    greatest = max(greatest, layer[r, c])
            out[i * pixels + j] = (2 * total + side * side) // (2 * side * side) if mean else greatest


@leaf(entry=False)
def _show_visits(visits: np.ndarray, layer: np.ndarray) -> None:
    for r in range(layer.shape[0]):
        for c in range(layer.shape[1]):
            layer[r, c] = 255 * min(visits[r, c], VISIT_CAP) // VISIT_CAP


@leaf(entry=False)
def _show_frontier(belief: np.ndarray, layer: np.ndarray) -> None:
    for r in range(layer.shape[0]):
        for c in range(layer.shape[1]):
            layer[r, c] = 255 if belief[r, c] == FREE and touches_unknown(belief, r, c) else 0


@leaf(entry=False)
def _show_distance(belief: np.ndarray, rate: float, scratch: Scratch) -> None:
    """Show the distance of known free cells to the nearest frontier cell; 255 elsewhere."""
    width, found = belief.shape[1], 0
    scratch.layer[:], scratch.steps[:] = 255, UNREACHABLE
    for r in range(belief.shape[0]):
        for c in range(width):
            if belief[r, c] == FREE and touches_unknown(belief, r, c):
                scratch.steps[r, c], scratch.queue[found] = 0, r * width + c
                found += 1
    for place in range(flood(belief, FREE, found, scratch.queue, scratch.steps)):
        r, c = divmod(scratch.queue[place], width)
        far = scratch.steps[r, c] * rate
        scratch.layer[r, c] = int(255.0 * far / (far + HALF_DISTANCE) + 0.5)


@leaf(entry=False)
def _freshness(age: int, rate: float) -> int:
    """Return the brightness of a teammate heard ``age`` steps ago: 255 for age 0, fading with age."""
    return int(255.0 * FADING ** (age * rate) + 0.5)


@leaf(entry=False)
def _show_mates(
    row: int, col: int, mates: np.ndarray, ages: np.ndarray, sensor: Sensor, side: int, past: int, out: np.ndarray
) -> None:
    """Show teammates on a map of blocks ``side`` cells wide: those heard now (``past`` 0), before (1) or ever (2)."""
    pixels = int(np.sqrt(out.shape[0]) + 0.5)
    first = -((pixels * side) // 2)
    out[:] = 0
    for m in range(ages.shape[0]):
        if ages[m] < 0 or (past == 0 and ages[m] > 0) or (past == 1 and ages[m] == 0):
            continue
        i, j = (mates[m, 0] - row - first) // side, (mates[m, 1] - col - first) // side
        if 0 <= i < pixels and 0 <= j < pixels:
            out[i * pixels + j] = max(out[i * pixels + j], _freshness(ages[m], sensor.rate))


@leaf(entry=False)
def _write_fine(uav: Uav, sensor: Sensor, scratch: Scratch, layout: ObservationLayout, out: np.ndarray) -> None:
    """Write the layers of the fine map, except those of teammates."""
    row, col, side, size = uav.row, uav.col, sensor.scale, layout.crop * layout.crop
    for layer in range(_MATES):
        at = layout.layers[layer]
        if at < 0:
            continue
        pixels = out[at : at + size]
        if layer == _UNKNOWN:
            _pool(scratch.unknown, row, col, layout.crop, side, pixels)
        elif layer == _FREE:
            _pool(scratch.free, row, col, layout.crop, side, pixels)
        elif layer == _CHANCE:
            _pool_layer(uav.chance, row, col, layout.crop, side, True, pixels)
        else:
            if layer == _VISITS:
                _show_visits(uav.visits, scratch.layer)
            elif layer == _FRONTIER:
                _show_frontier(uav.belief, scratch.layer)
            else:
                _show_distance(uav.belief, sensor.rate, scratch)
            _pool_layer(scratch.layer, row, col, layout.crop, side, False, pixels)


@leaf(entry=False)
def _write_sides(row: int, col: int, table: np.ndarray, disc: float, out: np.ndarray) -> None:
    """Write how many unknown cells are below, left of, above and right of the UAV, as x / (x + 4 disc)."""
    height, width = table.shape[0] - 1, table.shape[1] - 1
    sides = (
        within(table, row + 1, 0, height, width),
        within(table, 0, 0, height, col),
        within(table, 0, 0, row, width),
        within(table, 0, col + 1, height, width),
    )
    for k in range(4):
        out[k] = int(255.0 * sides[k] / (sides[k] + 4.0 * disc) + 0.5)


@leaf(entry=False)
def write_map_image(uav: Uav, sensor: Sensor, scratch: Scratch, layout: ObservationLayout, out: np.ndarray) -> None:
    """Write the map image (S,) uint8 of a UAV; the summed-area tables must be filled."""
    row, col, mates, ages = uav.row, uav.col, uav.mates, uav.ages
    fine, coarse = layout.crop * layout.crop, layout.coarse * layout.coarse
    _write_fine(uav, sensor, scratch, layout, out)
    for past in range(2):
        at = layout.layers[_MATES + past]
        if at >= 0:
            _show_mates(row, col, mates, ages, sensor, sensor.scale, past, out[at : at + fine])
    at = layout.coarse_at
    if at >= 0:
        _pool(scratch.unknown, row, col, layout.coarse, 3 * sensor.scale, out[at : at + coarse])
        _pool(scratch.free, row, col, layout.coarse, 3 * sensor.scale, out[at + coarse : at + 2 * coarse])
        if layout.coarse_mates:
            _show_mates(row, col, mates, ages, sensor, 3 * sensor.scale, 2, out[at + 2 * coarse : at + 3 * coarse])
    if layout.sides_at >= 0:
        _write_sides(row, col, scratch.unknown, sensor.disc, out[layout.sides_at : layout.sides_at + 4])
    if layout.identity_at >= 0:
        out[layout.identity_at : layout.identity_at + IDENTITIES] = 0
        out[layout.identity_at + uav.agent % IDENTITIES] = 255
    if layout.progress_at >= 0:
        share, wait = 1.0 - scratch.unknown[-1, -1] / uav.belief.size, float(uav.idle[0]) * sensor.rate
        out[layout.progress_at] = int(255.0 * share + 0.5)
        out[layout.progress_at + 1] = int(255.0 * min(uav.flown, 1.0) + 0.5)
        out[layout.progress_at + 2] = int(255.0 * wait / (wait + HALF_DISTANCE) + 0.5)
