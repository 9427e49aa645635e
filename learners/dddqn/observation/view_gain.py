"""View-gain features of the moves on maps of any size: the gains in the direction of each move, and their distances.

One breadth-first search from the UAV serves all four moves. The grid is bipartite, so a step to a neighbour changes
the distance to any cell by exactly one: it is one less if a shortest path begins with that step, and one more if none
does. The search stores, for every cell, the moves that begin a shortest path to it.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.cells import FREE, MOVES, UNKNOWN
from indoor_explorers.env.grid.compiled import leaf
from indoor_explorers.env.search.frontiers import touches_unknown
from indoor_explorers.env.sensing.lidar import unknown_in_view, visible_cells
from indoor_explorers.learners.dddqn.observation.map_image import HALF_DISTANCE, within
from indoor_explorers.learners.dddqn.observation.memory import SPENT, STALE
from indoor_explorers.learners.dddqn.observation.scales import Scratch, Sensor

#: Columns of ``Scratch.ahead``: the best gain for each discount, the sum of the gains, the steps to the nearest.
_SUM, _NEAREST = 3, 4
#: Half width of the square around an unknown cell in which known cells make it isolated, and the number of other cells
#: in the square.
AROUND, OTHERS = 2, 24
#: Additional weight of an unknown cell without another unknown one in that square.
ISOLATION = 8.0


@leaf(entry=False)
def forget_gains(gain: np.ndarray, box: np.ndarray, reach: int) -> None:
    """Mark the gains as stale that newly known cells in a ``box`` (top, left, bottom, right) may have changed."""
    for r in range(max(box[0] - reach, 0), min(box[2] + reach, gain.shape[0])):
        for c in range(max(box[1] - reach, 0), min(box[3] + reach, gain.shape[1])):
            if gain[r, c] != SPENT:
                gain[r, c] = STALE


@leaf(entry=False)
def _weigh(belief: np.ndarray, row: int, col: int, sensor: Sensor, scratch: Scratch) -> tuple[int, float]:
    """Return the number of unknown cells in view of a cell, and their sum with isolated ones weighted more."""
    width, found, weight = belief.shape[1], 0, 0.0
    for k in range(visible_cells(belief, row, col, sensor.lidar, scratch.scan)):
        r, c = divmod(scratch.scan.cells[k], width)
        if belief[r, c] == UNKNOWN:
            near = within(scratch.unknown, r - AROUND, c - AROUND, r + AROUND + 1, c + AROUND + 1)
            found += 1
            weight += 1.0 + ISOLATION * (OTHERS + 1 - near) / OTHERS
    return found, weight


@leaf(entry=False)
def gain_at(
    belief: np.ndarray, row: int, col: int, sensor: Sensor, scratch: Scratch, gain: np.ndarray, weight: np.ndarray
) -> int:
    """Return the view gain of a cell, the number of unknown cells in view; a stale entry of ``gain`` is recomputed.

    ``weight`` (H, W) gets the gain with isolated cells weighted more, unless it is empty. The summed-area tables must
    be filled.
    """
    if gain[row, col] == STALE:
        reach, gain[row, col] = sensor.reach, 0
        if within(scratch.unknown, row - reach, col - reach, row + reach + 1, col + reach + 1) > 0:
            if weight.shape[0] > 0:
                gain[row, col], weight[row, col] = _weigh(belief, row, col, sensor, scratch)
            else:
                gain[row, col] = unknown_in_view(belief, row, col, sensor.lidar, scratch.scan)
    return max(int(gain[row, col]), 0)


@leaf(entry=False)
def _on_lattice(row: int, col: int, shape: tuple[int, int], scale: int) -> bool:
    """Tell whether a cell lies on the lattice around the middle of the map, which the symmetries map to itself."""
    return (2 * row + 1 - shape[0]) % scale == 0 and (2 * col + 1 - shape[1]) % scale == 0


@leaf(entry=False)
def _spread(belief: np.ndarray, cell: int, scratch: Scratch, tail: int) -> int:
    """Expand a flat cell: enqueue new neighbours and pass on the first moves; return the new end of the queue."""
    steps, first, width = scratch.steps, scratch.first, belief.shape[1]
    row, col = divmod(cell, width)
    distance = steps[row, col] + 1
    for k in range(4):
        r, c = row + MOVES[k, 0], col + MOVES[k, 1]
        if not (0 <= r < belief.shape[0] and 0 <= c < width) or belief[r, c] != FREE:
            continue
        if steps[r, c] < 0:
            steps[r, c], first[r, c], scratch.queue[tail] = distance, 0, r * width + c
            tail += 1
        if steps[r, c] == distance:
            first[r, c] |= 1 << k if distance == 1 else first[row, col]
    return tail


@leaf(entry=False)
def _credit(gain: int, steps: int, first: int, share: float, sensor: Sensor, scratch: Scratch) -> None:
    """Add a gain ``steps`` steps from the UAV to the sums and maxima ahead of all moves.

    ``first`` are the moves, one bit each, that begin a shortest path to it; ``share`` is its weight in the sum.
    ``scratch.power`` holds the discount factors of ``steps`` - 1.
    """
    ahead, power, decay = scratch.ahead, scratch.power, sensor.decay
    for k in range(4):
        nearer = first >> k & 1
        for j in range(3):
            factor = power[j] if nearer else power[j] * decay[j] * decay[j]
            ahead[k, j] = max(ahead[k, j], gain * factor)
        ahead[k, _SUM] += gain * share * (power[0] if nearer else power[0] * decay[0] * decay[0])
        distance = steps - 1 if nearer else steps + 1
        if ahead[k, _NEAREST] < 0 or distance < ahead[k, _NEAREST]:
            ahead[k, _NEAREST] = distance


@leaf(entry=False)
def flood_gains(
    belief: np.ndarray, row: int, col: int, sensor: Sensor, scratch: Scratch, gains: np.ndarray, weights: np.ndarray
) -> int:
    """Fill ``scratch.ahead`` with the view gains of the reachable frontier cells and of a lattice of reachable cells.

    Returns the steps to the nearest gain, -1 if no reachable cell has one. The summed-area tables must be filled;
    ``gains`` (H, W) and ``weights`` are updated as by :func:`gain_at`.
    """
    width, nearest, at, head, tail = belief.shape[1], -1, 0, 0, 1
    weight = (sensor.scale * sensor.rate) ** 2
    scratch.steps[:] = -1
    scratch.steps[row, col], scratch.first[row, col], scratch.queue[0] = 0, 0, row * width + col
    scratch.ahead[:], scratch.ahead[:, _NEAREST] = 0.0, -1.0
    for j in range(3):
        scratch.power[j] = 1.0 / sensor.decay[j]
    while head < tail:
        cell = scratch.queue[head]
        head += 1
        tail = _spread(belief, cell, scratch, tail)
        r, c = divmod(cell, width)
        on_lattice = _on_lattice(r, c, belief.shape, sensor.scale)
        gain = 0
        if on_lattice or touches_unknown(belief, r, c):
            gain = gain_at(belief, r, c, sensor, scratch, gains, weights)
        if gain == 0:
            continue
        while at < scratch.steps[r, c]:
            at += 1
            for j in range(3):
                scratch.power[j] *= sensor.decay[j]
        if nearest < 0:
            nearest = at
        _credit(gain, at, scratch.first[r, c], weight if on_lattice else 0.0, sensor, scratch)
    return nearest


@leaf(entry=False)
def write_gains(move: int, here: int, sensor: Sensor, scratch: Scratch, out: np.ndarray) -> None:
    """Write the features :data:`~indoor_explorers.learners.dddqn.observation.layout.GAINS` of one legal move.

    ``here`` is the gain of the next cell; the rest was computed by :func:`flood_gains`. ``out`` (6 or more,) float32
    begins with these features.
    """
    ahead = scratch.ahead[move]
    distance = ahead[_NEAREST] * sensor.rate
    out[0] = np.sqrt(here / sensor.disc)
    out[1] = distance / (distance + HALF_DISTANCE) if distance >= 0 else 1.0
    for j in range(4):
        out[2 + j] = np.sqrt(ahead[j] / sensor.disc)
