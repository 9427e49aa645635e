"""Planner features of the moves on maps of any size: what could be gained behind each of them, and how far away."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.compiled import leaf
from indoor_explorers.env.grid import MOVES, distances_from, touches_unknown
from indoor_explorers.env.lidar import unknown_in_view
from indoor_explorers.learners.dddqn.scene import HALF_DISTANCE, within
from indoor_explorers.learners.dddqn.sensor import Scratch, Sensor


@leaf()
def gain_at(belief: np.ndarray, row: int, col: int, sensor: Sensor, scratch: Scratch) -> int:
    """Return the unknown cells in view of a cell; the summed-area tables must be filled."""
    reach = sensor.reach
    if within(scratch.unknown, row - reach, col - reach, row + reach + 1, col + reach + 1) == 0:
        return 0
    return unknown_in_view(belief, row, col, sensor.optics, scratch.scan)


@leaf()
def survey(belief: np.ndarray, row: int, col: int, sensor: Sensor, scratch: Scratch) -> int:
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
            gain = gain_at(belief, r, c, sensor, scratch)
        scratch.gain[r, c] = gain
        if gain > 0 and nearest < 0:
            nearest = scratch.steps[r, c]
    return nearest


@leaf()
def look_ahead(
    belief: np.ndarray, row: int, col: int, move: int, sensor: Sensor, scratch: Scratch, out: np.ndarray
) -> None:
    """Write the six gains of one legal move into ``out``: see :data:`indoor_explorers.learners.dddqn.layout.GAINS`."""
    width = belief.shape[1]
    r0, c0 = row + MOVES[move, 0], col + MOVES[move, 1]
    here = gain_at(belief, r0, c0, sensor, scratch)
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
    out[0] = np.sqrt(here / sensor.disc)
    out[1] = distance / (distance + HALF_DISTANCE) if nearest >= 0 else 1.0
    out[2], out[3], out[4] = np.sqrt(near / sensor.disc), np.sqrt(middle / sensor.disc), np.sqrt(far / sensor.disc)
    out[5] = np.sqrt(total)
