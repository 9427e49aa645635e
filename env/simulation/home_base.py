"""The home base: a fixed cell with a radio and a map, in contact with UAVs nearby, by radio, and through other UAVs.

The base takes part in the exchange of a step like a UAV: UAVs in contact with it, directly or through teammates, merge
their maps with its map.
"""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.grid.compiled import inner
from indoor_explorers.env.grid.levels import enter_between, offset, rise_of
from indoor_explorers.env.scenarios.codes import RadioModel
from indoor_explorers.env.simulation.radio import CELL_BYTES, in_contact, is_lost, join, learn
from indoor_explorers.env.simulation.state import End, Rules, State

FLYING, CUSTOM = int(End.FLYING), int(RadioModel.CUSTOM)


@inner()
def place_base(rules: Rules, state: State, b: int) -> None:
    """Place the base of an episode whose spawns are in place, with an empty map."""
    state.base_cell[b, 0], state.base_cell[b, 1] = rules.base_row, rules.base_col
    if rules.base_row < 0:
        state.base_cell[b, 0], state.base_cell[b, 1] = state.cell[b, 0, 0], state.cell[b, 0, 1]
    state.base_belief[b, :, :] = UNKNOWN
    if rules.base:
        enter_between(state.base_belief[b], rules.levels)
    state.base_known[b] = state.base_covered[b] = 0
    for n in range(state.end.shape[1]):
        state.base_merged[b, n] = state.base_sent[b, n] = 0
        state.base_contact[b, n] = False
        state.base_step[b, n] = -1


@inner()
def _reaches(rules: Rules, state: State, b: int, agent: int) -> bool:
    """Tell whether an agent is in direct contact with the base."""
    row, col = state.cell[b, agent, 0], state.cell[b, agent, 1]
    base_row, base_col = state.base_cell[b, 0], state.base_cell[b, 1]
    if state.end[b, agent] != FLYING:
        return False
    levels, rows, cols = offset(row, col, base_row, base_col, rise_of(state.truth.shape[1], rules.levels))
    if levels * levels + rows * rows + cols * cols <= rules.base_radius * rules.base_radius + 1e-9:
        return True
    if rules.radio_model == CUSTOM or state.step[b] < state.silent_until[b, agent]:
        return False
    return in_contact(rules, state, b, row, col, base_row, base_col) and not is_lost(rules, state, b, agent, agent)


@inner()
def link_base(rules: Rules, state: State, b: int, component: np.ndarray) -> bool:
    """Fill ``base_contact`` and join the components (N,) in contact with the base; return whether any is."""
    first = -1
    for n in range(state.end.shape[1]):
        if _reaches(rules, state, b, n):
            if first >= 0:
                join(component, first, n)
            else:
                first = n
    for n in range(state.end.shape[1]):
        state.base_contact[b, n] = first >= 0 and component[n] == component[first]
    return first >= 0


@inner()
def report(state: State, b: int) -> None:
    """Merge the maps of the base and of the agents in contact with it, after these have merged theirs."""
    team = state.end.shape[1]
    for n in range(team):
        if state.base_contact[b, n]:
            _take_over(state, b, n)
    for n in range(team):
        if state.base_contact[b, n]:
            for k in range(state.base_sent[b, n], state.base_known[b]):
                cell = state.base_log[b, k]
                if state.belief[b, n].flat[cell] == UNKNOWN:
                    learn(state, b, n, cell)
                    state.received[b, n] += 1
            state.base_sent[b, n] = state.base_known[b]
            state.base_merged[b, n] = state.known[b, n]
            state.base_step[b, n] = state.step[b]
    for n in range(team):
        for mate in range(team):
            if n != mate and state.base_contact[b, n] and state.base_contact[b, mate]:
                state.merged_up_to[b, n, mate] = state.known[b, mate]


@inner()
def _take_over(state: State, b: int, agent: int) -> None:
    """Enter what an agent has learned since its last report into the map of the base."""
    belief, truth, counts = state.base_belief[b].flat, state.truth[b].flat, state.counts[b].flat
    for k in range(state.base_merged[b, agent], state.known[b, agent]):
        cell = state.discovery_log[b, agent, k]
        if belief[cell] == UNKNOWN:
            belief[cell] = truth[cell]
            state.base_log[b, state.base_known[b]] = cell
            state.base_known[b] += 1
            state.base_covered[b] += counts[cell]
            state.sent_bytes[b, agent] += CELL_BYTES
