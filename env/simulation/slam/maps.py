"""Maps of log-odds, compiled: scans are drawn into them, and drawn again elsewhere when a path is corrected."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.compiled import inner, leaf
from indoor_explorers.env.simulation.slam.scans import read_scan
from indoor_explorers.env.simulation.slam.state import Slam, SlamParts
from indoor_explorers.env.simulation.state import End, State

STOPPED = int(End.STOPPED)


@inner()
def _show(state: State, b: int, holder: int, cell: int, value: np.uint8) -> bool:
    """Set a flat cell of a holder's map and update its count of correct cells; return whether it has become known."""
    team = state.end.shape[1]
    if holder < team:
        belief = state.belief[b, holder]
    elif holder == team:
        belief = state.union[b]
    else:
        belief = state.base_belief[b]
    before, truth = belief.flat[cell], state.truth[b].flat[cell]
    if before == value:
        return False
    belief.flat[cell] = value
    if state.counts[b].flat[cell]:
        change = int(value == truth) - int(before == truth)
        if holder < team:
            state.covered[b, holder] += change
        elif holder == team:
            state.team_covered[b] += change
        else:
            state.base_covered[b] += change
    return bool(before == UNKNOWN)


@inner()
def _thresholded(log_odds: float) -> np.uint8:
    """Return a cell's value on a map: unknown without evidence, else the more probable one."""
    if log_odds == 0.0:
        return UNKNOWN
    return OCCUPIED if log_odds > 0.0 else FREE


@inner()
def move_scan(parts: SlamParts, count: int, b: int, holder: int, agent: int, number: int, pose: int) -> int:
    """Move the scan in ``readings`` on a holder's map to the flat cell ``pose``; -1 removes it.

    Returns the number of cells that the holder knows for the first time.
    """
    slam, new = parts.slam, 0
    own, before = slam.true_cell[b, agent, number], slam.drawn_at[b, holder, agent, number]
    if before >= 0:
        _draw_scan(parts, count, b, holder, own, before, -1.0)
    if pose >= 0:
        new = _draw_scan(parts, count, b, holder, own, pose, 1.0)
    slam.drawn_at[b, holder, agent, number] = pose
    return new


@leaf(entry=False)
def _draw_scan(parts: SlamParts, count: int, b: int, holder: int, own: int, pose: int, sign: float) -> int:
    """Add the scan in ``readings``, made in the flat cell ``own``, to a holder's map as if made in ``pose``.

    ``sign`` is 1, or -1 to remove it. Returns the number of cells that the holder knows for the first time.
    """
    state, slam, readings = parts.state, parts.slam, parts.readings
    height, width, team = state.truth.shape[1], state.truth.shape[2], state.end.shape[1]
    down, right = pose // width - own // width, pose % width - own % width
    log_odds, new = slam.log_odds[b, holder], 0
    for k in range(count):
        row, col = readings.cells[k] // width + down, readings.cells[k] % width + right
        if row < 0 or row >= height or col < 0 or col >= width:
            continue
        log_odds[row, col] += np.float32(sign) * readings.values[k]
        cell = row * width + col
        if holder < team and cell == slam.shown_free[b, holder]:
            continue
        known = _show(state, b, holder, cell, _thresholded(log_odds[row, col]))
        if known and holder < team:
            new += _list(state, slam, b, holder, cell)
    return new


@inner()
def _list(state: State, slam: Slam, b: int, agent: int, cell: int) -> bool:
    """Enter a cell into an agent's discovery log; return whether it was not there yet."""
    if slam.listed[b, agent].flat[cell]:
        return False
    slam.listed[b, agent].flat[cell] = True
    state.discovery_log[b, agent, state.known[b, agent]] = cell
    state.known[b, agent] += 1
    return True


@inner()
def place_agent(state: State, slam: Slam, b: int, agent: int) -> None:
    """Show an agent's believed cell as free on its map, and the previous one by its evidence again."""
    width, before = state.truth.shape[2], slam.shown_free[b, agent]
    cell = state.believed_cell[b, agent, 0] * width + state.believed_cell[b, agent, 1]
    state.visited[b, agent].flat[cell] = True
    if cell == before:
        return
    slam.shown_free[b, agent] = cell
    if before >= 0:
        _show(state, b, agent, before, _thresholded(slam.log_odds[b, agent].flat[before]))
    if _show(state, b, agent, cell, FREE):
        _list(state, slam, b, agent, cell)


@inner()
def redraw(parts: SlamParts, b: int, agent: int, number: int, pose: int) -> None:
    """Move a scan of an agent that flies to another pose, in its own map and the team's."""
    count = read_scan(parts, b, agent, number)
    for holder in (agent, parts.state.end.shape[1]):
        move_scan(parts, count, b, holder, agent, number, pose)


@inner()
def _remaining_pose(state: State, slam: Slam, b: int, agent: int, number: int) -> int:
    """Return the pose at which the first remaining holder has an agent's scan; -1 for none."""
    team, holders = state.end.shape[1], slam.drawn_at.shape[1]
    if state.end[b, agent] != STOPPED:
        return int(slam.drawn_at[b, agent, agent, number])
    for holder in range(holders):
        lost = holder == team or (holder < team and state.end[b, holder] == STOPPED)
        if not lost and slam.drawn_at[b, holder, agent, number] >= 0:
            return int(slam.drawn_at[b, holder, agent, number])
    return -1


@leaf(entry=False)
def forget_lost(parts: SlamParts, b: int) -> None:
    """Remove the scans that only stopped agents have from the team's map."""
    state, slam, team = parts.state, parts.slam, parts.state.end.shape[1]
    for agent in range(team):
        for number in range(slam.scans[b, agent, agent]):
            before, pose = slam.drawn_at[b, team, agent, number], _remaining_pose(state, slam, b, agent, number)
            if before != pose:
                move_scan(parts, read_scan(parts, b, agent, number), b, team, agent, number, pose)
