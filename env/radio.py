"""Radio: who is linked, and what linked agents exchange.

Linked agents form connected components. Once per step, after all moves, every component merges its maps
and exchanges positions and messages. Each agent keeps a journal of its known cells in the order they
became known, and for every teammate how far it has read that one's journal: a merge touches what
changed since the last one and never the map.

Bytes are counted at the sender: ``CELL_BYTES`` for each cell that was new to the receiver, and for each
teammate in the component one position and message of ``POSITION_BYTES`` + 8 for each number.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from indoor_explorers.env.grid import UNKNOWN
from indoor_explorers.env.state import Rules, State

CELL_BYTES = 5
POSITION_BYTES = 8


@njit(cache=True, nogil=True, inline="always")
def in_contact(rules: Rules, rows: int, cols: int) -> bool:
    """Tell whether two agents ``rows`` and ``cols`` apart are linked directly."""
    if rules.radio_model == 0:
        return False
    if rules.radio_model == 1:
        return max(abs(rows), abs(cols)) <= rules.radio_range
    if rules.radio_model == 2:
        return rows * rows + cols * cols <= rules.radio_range * rules.radio_range + 1e-9
    return True


@njit(cache=True, nogil=True, inline="always")
def link(rules: Rules, state: State, b: int, component: np.ndarray) -> None:
    """Fill ``linked`` and ``component`` (N,), the smallest agent number of each agent's component."""
    team = state.end.shape[1]
    for i in range(team):
        component[i] = i
        for j in range(i):
            together = (
                state.end[b, i] == 0
                and state.end[b, j] == 0
                and in_contact(
                    rules,
                    state.cell[b, i, 0] - state.cell[b, j, 0],
                    state.cell[b, i, 1] - state.cell[b, j, 1],
                )
            )
            state.linked[b, i, j] = state.linked[b, j, i] = together
    changed = True
    while changed:
        changed = False
        for i in range(team):
            for j in range(team):
                if state.linked[b, i, j] and component[j] < component[i]:
                    component[i] = component[j]
                    changed = True


@njit(cache=True, nogil=True, inline="always")
def learn(state: State, b: int, agent: int, cell: int) -> None:
    """Enter a flat cell that was unknown to ``agent`` into its belief and journal."""
    state.belief[b, agent].reshape(-1)[cell] = state.truth[b].reshape(-1)[cell]
    state.journal[b, agent, state.known[b, agent]] = cell
    state.known[b, agent] += 1
    if state.counts[b].reshape(-1)[cell]:
        state.covered[b, agent] += 1


@njit(cache=True, nogil=True, inline="always")
def exchange(state: State, b: int, component: np.ndarray) -> None:
    """Merge maps and exchange positions and messages within each component."""
    team = state.end.shape[1]
    before = state.known[b].copy()
    for i in range(team):
        for j in range(team):
            if i == j or component[i] != component[j]:
                continue
            for k in range(state.read[b, i, j], before[j]):
                cell = state.journal[b, j, k]
                if state.belief[b, i].reshape(-1)[cell] == UNKNOWN:
                    learn(state, b, i, cell)
                    state.received[b, i] += 1
                    state.sent_bytes[b, j] += CELL_BYTES
            state.heard_step[b, i, j] = state.step[b]
            state.heard_cell[b, i, j] = state.cell[b, j]
            state.heard_size[b, i, j] = state.outbox_size[b, j]
            state.heard[b, i, j] = state.outbox[b, j]
            state.sent_bytes[b, j] += POSITION_BYTES + 8 * max(0, state.outbox_size[b, j])
    for i in range(team):
        for j in range(team):
            if i != j and component[i] == component[j]:
                state.read[b, i, j] = state.known[b, j]
