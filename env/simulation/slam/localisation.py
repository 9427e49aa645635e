"""Localisation, compiled: drifting pose estimates and their corrections.

Pose estimates follow the intended moves. After each cell flown, with a set probability, a UAV slips unnoticed by one
cell in a random direction, if that cell is open. A UAV that returns to a cell that it visited some steps ago with a
lower variance adopts the pose estimate of that visit (loop closure). A UAV that is linked to a visible teammate with a
lower variance adopts the pose that follows from the teammate's. The correction is distributed over the path since the
last pose of at most the new variance, in proportion to the cells flown, and the map is drawn again. The variance of a
pose is that of a random walk; between two corrected poses that of a Brownian bridge.
"""

from __future__ import annotations

from math import floor, sqrt

import numpy as np

from indoor_explorers.env.grid.cells import FREE, MOVES
from indoor_explorers.env.grid.compiled import inner, leaf
from indoor_explorers.env.grid.lines import walls_between
from indoor_explorers.env.grid.randomness import uniform
from indoor_explorers.env.sensing.lidar import LidarModel
from indoor_explorers.env.simulation.slam.maps import redraw
from indoor_explorers.env.simulation.slam.state import ErrorRules, Slam, SlamParts
from indoor_explorers.env.simulation.state import End, State
from indoor_explorers.env.simulation.step import is_taken

FLYING = int(End.FLYING)
#: The kinds of draws for each agent in each step, and their number.
SLIP, DIRECTION, CLOSURE, KINDS = 0, 1, 2, 3


@inner()
def _drawn(state: State, slam: Slam, b: int, agent: int, kind: int) -> float:
    return uniform(slam.drift_key[b], (state.step[b] * state.end.shape[1] + agent) * KINDS + kind)


@inner()
def _believe(state: State, b: int, agent: int, row: int, col: int) -> None:
    """Set an agent's believed cell, clipped to the map, whose size agents know."""
    state.believed_cell[b, agent, 0] = min(max(row, 0), state.truth.shape[1] - 1)
    state.believed_cell[b, agent, 1] = min(max(col, 0), state.truth.shape[2] - 1)


@inner()
def _is_open(state: State, b: int, row: int, col: int) -> bool:
    """Tell whether a cell is free, and no agent flies in it."""
    inside = 0 <= row < state.truth.shape[1] and 0 <= col < state.truth.shape[2]
    return inside and state.truth[b, row, col] == FREE and not is_taken(state, b, row, col)


@inner()
def drift(rules: ErrorRules, state: State, slam: Slam, b: int, agent: int, action: int) -> None:
    """Apply an agent's move to its believed cell, and a random slip to its true cell."""
    row, col = state.believed_cell[b, agent, 0], state.believed_cell[b, agent, 1]
    _believe(state, b, agent, row + MOVES[action, 0], col + MOVES[action, 1])
    if rules.drift > 0.0 and _drawn(state, slam, b, agent, SLIP) < rules.drift:
        slip = int(4.0 * _drawn(state, slam, b, agent, DIRECTION))
        row, col = state.cell[b, agent, 0] + MOVES[slip, 0], state.cell[b, agent, 1] + MOVES[slip, 1]
        if _is_open(state, b, row, col):
            state.cell[b, agent, 0], state.cell[b, agent, 1] = row, col
            state.path_length[b, agent] += -1 if slip == (action + 2) % 4 else 1


@inner()
def _anchor(slam: Slam, b: int, agent: int, before: int, variance: float) -> int:
    """Return the last scan before ``before`` whose pose has at most ``variance``, the first if none has."""
    number = before - 1
    while number > 0 and slam.variance[b, agent, number] > variance:
        number -= 1
    return number


@leaf(entry=False)
def _correct(parts: SlamParts, b: int, agent: int, row: int, col: int, variance: float, now: int, end: int) -> None:
    """Set an agent's believed cell and its variance, and distribute the correction over the scans before ``end``.

    ``now`` is the number of the scan at the believed cell, which may be made later.
    """
    state, slam = parts.state, parts.slam
    width, team = state.truth.shape[2], state.end.shape[1]
    before_row, before_col = state.believed_cell[b, agent, 0], state.believed_cell[b, agent, 1]
    _believe(state, b, agent, row, col)
    down, right = state.believed_cell[b, agent, 0] - before_row, state.believed_cell[b, agent, 1] - before_col
    anchor = _anchor(slam, b, agent, now, variance)
    start, length = slam.way[b, agent, anchor], slam.way[b, agent, now] - slam.way[b, agent, anchor]
    slam.variance[b, agent, now] = variance
    changed = False
    for number in range(anchor + 1, end):
        share = (slam.way[b, agent, number] - start) / max(length, 1)
        bridge = variance + parts.errors.drift * length * share * (1.0 - share)
        slam.variance[b, agent, number] = min(slam.variance[b, agent, number], np.float32(bridge))
        before = slam.drawn_at[b, agent, agent, number]
        r = min(max(before // width + floor(share * down + 0.5), 0), state.truth.shape[1] - 1)
        c = min(max(before % width + floor(share * right + 0.5), 0), width - 1)
        if r * width + c != before:
            redraw(parts, b, agent, number, r * width + c)
            changed = True
    if changed:
        slam.revision[b, agent, agent] += 1
        slam.revision[b, team, agent] += 1


@inner()
def close_loop(parts: SlamParts, b: int, agent: int) -> None:
    """Correct the pose of an agent that returns to a visited cell, before its scan there."""
    rules, state, slam = parts.errors, parts.state, parts.slam
    now, width = state.step[b], state.truth.shape[2]
    first = slam.first_visit[b, agent, state.cell[b, agent, 0], state.cell[b, agent, 1]]
    if first < 0 or now - first < rules.closure_gap:
        return
    variance = slam.variance[b, agent, first]
    if variance >= slam.variance[b, agent, now] or _drawn(state, slam, b, agent, CLOSURE) >= rules.closures:
        return
    row, col = divmod(slam.drawn_at[b, agent, agent, first], width)
    _correct(parts, b, agent, row, col, variance, now, now)


@inner()
def _sees(state: State, lidar: LidarModel, b: int, i: int, j: int) -> bool:
    """Tell whether two agents are in each other's lidar range, with no obstacle between."""
    row, col, to_row, to_col = state.cell[b, i, 0], state.cell[b, i, 1], state.cell[b, j, 0], state.cell[b, j, 1]
    squared = (row - to_row) ** 2 + (col - to_col) ** 2
    if squared > lidar.range * lidar.range + 1e-9:
        return False
    return walls_between(state.truth[b], row, col, to_row, to_col) == 0


@inner()
def meet_mates(parts: SlamParts, b: int) -> None:
    """Correct the poses of agents that are linked to a visible teammate of lower pose variance."""
    state, slam, now = parts.state, parts.slam, parts.state.step[b]
    for i in range(state.end.shape[1]):
        for j in range(state.end.shape[1]):
            if i == j or not state.linked[b, i, j] or not _sees(state, parts.lidar, b, i, j):
                continue
            variance = slam.variance[b, j, now]
            if variance < slam.variance[b, i, now]:
                row = state.believed_cell[b, j, 0] + state.cell[b, i, 0] - state.cell[b, j, 0]
                col = state.believed_cell[b, j, 1] + state.cell[b, i, 1] - state.cell[b, j, 1]
                _correct(parts, b, i, row, col, variance, now, now + 1)


@inner()
def count_errors(state: State, slam: Slam, b: int) -> None:
    """Add the distances between the believed and the true cells of the agents that fly."""
    for n in range(state.end.shape[1]):
        if state.end[b, n] == FLYING:
            rows = state.believed_cell[b, n, 0] - state.cell[b, n, 0]
            cols = state.believed_cell[b, n, 1] - state.cell[b, n, 1]
            slam.pose_error[b, n] += sqrt(rows * rows + cols * cols)
