"""Radio: links between agents, and the exchange of linked agents.

Linked agents form connected components. Once per step, after all moves, every component merges its maps and exchanges
positions and messages. Each agent has a discovery log, its known cells in the order they became known, and for every
teammate the merged length of that one's log: a merge processes only new entries and never the whole map.

Bytes are counted at the sender: ``CELL_BYTES`` for each cell that was new to the receiver, and for each
teammate in the component one position and message of ``POSITION_BYTES`` + 8 for each number.
"""

from __future__ import annotations

from math import log10

import numpy as np

from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.grid.compiled import inner
from indoor_explorers.env.grid.levels import offset, rise_of
from indoor_explorers.env.grid.lines import walls_between
from indoor_explorers.env.grid.randomness import uniform
from indoor_explorers.env.scenarios.codes import RadioModel
from indoor_explorers.env.simulation.path_loss import is_within_path_loss
from indoor_explorers.env.simulation.state import Rules, State

CELL_BYTES = 5
POSITION_BYTES = 8

NONE, SQUARE, DISC, LINE_OF_SIGHT, PATH_LOSS, UNLIMITED, CUSTOM, PATH_LOSS_IR2 = (int(model) for model in RadioModel)


@inner()
def in_reach(rules: Rules, occupancy: np.ndarray, row: int, col: int, to_row: int, to_col: int) -> bool:
    """Tell whether the radios in two cells of a true map (H, W) reach each other, without random losses."""
    levels, rows, cols = offset(row, col, to_row, to_col, rise_of(occupancy.shape[0], rules.levels))
    model, reach = rules.radio_model, rules.radio_range
    if model == NONE:
        return False
    if model == UNLIMITED:
        return True
    if model == SQUARE:
        return bool(max(abs(levels), abs(rows), abs(cols)) <= reach)
    squared = levels * levels + rows * rows + cols * cols
    if squared > reach * reach + 1e-9:
        return False
    if model == DISC:
        return True
    walls = walls_between(occupancy, row, col, to_row, to_col)
    if model == LINE_OF_SIGHT:
        return walls == 0
    spare = 5.0 * rules.radio_exponent * log10(max(reach * reach, 1e-9) / squared)
    return bool(walls * rules.radio_wall_loss <= spare + 1e-9)


@inner()
def in_contact(rules: Rules, state: State, b: int, row: int, col: int, to_row: int, to_col: int) -> bool:
    """Tell whether the radios in two cells reach each other in an episode, losses left out."""
    if rules.radio_model == PATH_LOSS_IR2:
        return is_within_path_loss(state.truth[b], rules.radio_range, state.fading[b], row, col, to_row, to_col)
    return in_reach(rules, state.truth[b], row, col, to_row, to_col)


@inner()
def is_lost(rules: Rules, state: State, b: int, i: int, j: int) -> bool:
    """Draw whether the contact of two agents fails in this step; ``i == j`` is the contact with the base."""
    if rules.radio_loss <= 0.0:
        return False
    team = state.end.shape[1]
    return uniform(state.radio_key[b], (state.step[b] * team + i) * team + j) < rules.radio_loss


@inner()
def link(rules: Rules, state: State, b: int, component: np.ndarray) -> bool:
    """Fill ``linked`` and ``component`` (N,), the smallest agent number of each agent's component.

    Returns whether any two agents are linked. For a plug-in's radio, ``linked`` contains its pairs before.
    """
    team, any_link = state.end.shape[1], False
    for i in range(team):
        component[i] = i
    for i in range(team):
        for j in range(i):
            together = (
                state.end[b, i] == 0
                and state.end[b, j] == 0
                and not (rules.failures and state.step[b] < max(state.silent_until[b, i], state.silent_until[b, j]))
                and (
                    state.linked[b, i, j]
                    if rules.radio_model == CUSTOM
                    else in_contact(
                        rules,
                        state,
                        b,
                        state.cell[b, i, 0],
                        state.cell[b, i, 1],
                        state.cell[b, j, 0],
                        state.cell[b, j, 1],
                    )
                )
                and not is_lost(rules, state, b, i, j)
            )
            state.linked[b, i, j] = state.linked[b, j, i] = together
            if together:
                any_link = True
                join(component, i, j)
    return any_link


@inner()
def join(component: np.ndarray, i: int, j: int) -> None:
    """Give the components (N,) of two agents the smaller of their numbers."""
    if component[i] == component[j]:
        return
    kept, gone = min(component[i], component[j]), max(component[i], component[j])
    for k in range(component.shape[0]):
        if component[k] == gone:
            component[k] = kept


@inner()
def learn(state: State, b: int, agent: int, cell: int) -> None:
    """Enter a flat cell that was unknown to ``agent`` into its belief and discovery log."""
    state.belief[b, agent].flat[cell] = state.truth[b].flat[cell]
    state.discovery_log[b, agent, state.known[b, agent]] = cell
    state.known[b, agent] += 1
    state.covered[b, agent] += state.counts[b].flat[cell]


@inner()
def _take_over(state: State, b: int, i: int, j: int, until: int) -> None:
    """Let agent ``i`` learn what agent ``j`` has learned up to entry ``until`` of its discovery log."""
    belief = state.belief[b, i].flat
    for k in range(state.merged_up_to[b, i, j], until):
        cell = state.discovery_log[b, j, k]
        if belief[cell] == UNKNOWN:
            learn(state, b, i, cell)
            state.received[b, i] += 1
            state.sent_bytes[b, j] += CELL_BYTES


@inner()
def hear(state: State, b: int, i: int, j: int) -> None:
    """Let agent ``i`` hear the position and message of agent ``j``."""
    size = state.outbox_size[b, j]
    state.last_received_step[b, i, j] = state.step[b]
    state.last_received_cell[b, i, j, 0] = state.believed_cell[b, j, 0]
    state.last_received_cell[b, i, j, 1] = state.believed_cell[b, j, 1]
    state.last_received_size[b, i, j] = size
    for k in range(size):
        state.last_received[b, i, j, k] = state.outbox[b, j, k]
    state.sent_bytes[b, j] += POSITION_BYTES + 8 * max(0, size)


@inner()
def exchange(state: State, b: int, component: np.ndarray, before: np.ndarray) -> None:
    """Merge maps and exchange positions and messages within each component; ``before`` (N,) is scratch."""
    team = state.end.shape[1]
    for j in range(team):
        before[j] = state.known[b, j]
    for i in range(team):
        for j in range(team):
            if i != j and component[i] == component[j]:
                _take_over(state, b, i, j, before[j])
                hear(state, b, i, j)
    for i in range(team):
        for j in range(team):
            if i != j and component[i] == component[j]:
                state.merged_up_to[b, i, j] = state.known[b, j]
