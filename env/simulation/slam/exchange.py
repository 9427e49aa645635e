"""The exchange of linked agents and the home base in worlds with errors, compiled.

Agents send scans with their current pose estimates, their own and those of others, and never sums: so no reading counts
twice, and a receiver of corrected poses draws its map again. Bytes are counted at the sender: ``CELL_BYTES`` for each
reading of a scan that is new to the receiver, ``POSITION_BYTES`` for a corrected pose, and positions and messages as in
:mod:`indoor_explorers.env.simulation.radio`.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.compiled import inner, leaf
from indoor_explorers.env.simulation.radio import CELL_BYTES, POSITION_BYTES, hear
from indoor_explorers.env.simulation.slam.maps import move_scan
from indoor_explorers.env.simulation.slam.scans import read_scan
from indoor_explorers.env.simulation.slam.state import Slam, SlamParts
from indoor_explorers.env.simulation.state import State


@inner()
def _takes_part(state: State, b: int, component: np.ndarray, root: int, holder: int, based: bool) -> bool:
    """Tell whether a map holder is in the component of an agent: another agent, or the base."""
    team = state.end.shape[1]
    if holder < team:
        return bool(component[holder] == root)
    return bool(holder == team + 1 and based and state.base_contact[b, root])


@inner()
def _freshest(
    state: State, slam: Slam, b: int, agent: int, component: np.ndarray, root: int, based: bool
) -> tuple[int, bool]:
    """Return the holder in a component with the most scans of an agent's path, and whether another one has fewer."""
    source, behind = root, False
    for holder in range(slam.scans.shape[1]):
        if holder != root and _takes_part(state, b, component, root, holder, based):
            behind |= slam.scans[b, holder, agent] != slam.scans[b, source, agent]
            if slam.scans[b, holder, agent] > slam.scans[b, source, agent]:
                source = holder
    return source, behind


@leaf(entry=False)
def _send(parts: SlamParts, b: int, agent: int, component: np.ndarray, root: int, source: int, based: bool) -> None:
    """Copy an agent's path from ``source`` to all holders of a component."""
    state, slam = parts.state, parts.slam
    team, holders = state.end.shape[1], slam.scans.shape[1]
    known, revision = slam.scans[b, source, agent], slam.revision[b, source, agent]
    start = known
    for holder in range(holders):
        if _takes_part(state, b, component, root, holder, based):
            same = slam.revision[b, holder, agent] == revision
            start = min(start, slam.scans[b, holder, agent] if same else 0)
    for number in range(start, known):
        pose, count = slam.drawn_at[b, source, agent, number], 0
        for holder in range(holders):
            before = slam.drawn_at[b, holder, agent, number]
            if before == pose or not _takes_part(state, b, component, root, holder, based):
                continue
            if count == 0:
                count = read_scan(parts, b, agent, number)
            new = move_scan(parts, count, b, holder, agent, number, pose)
            if holder < team:
                state.received[b, holder] += new
            if source < team:
                state.sent_bytes[b, source] += POSITION_BYTES if before >= 0 else CELL_BYTES * count
    for holder in range(holders):
        if _takes_part(state, b, component, root, holder, based):
            slam.scans[b, holder, agent], slam.revision[b, holder, agent] = known, revision


@inner()
def share(parts: SlamParts, b: int, based: bool) -> None:
    """Exchange scans, positions and messages within each component; ``based``: the base is in contact."""
    state, slam, component, team = parts.state, parts.slam, parts.work.component, parts.state.end.shape[1]
    for root in range(team):
        if component[root] == root:
            for agent in range(team):
                source, behind = _freshest(state, slam, b, agent, component, root, based)
                if behind:
                    _send(parts, b, agent, component, root, source, based)
    for i in range(team):
        for j in range(team):
            if i != j and component[i] == component[j]:
                hear(state, b, i, j)
        if based and state.base_contact[b, i]:
            state.base_step[b, i] = state.step[b]
