"""The one step of the world, compiled: moves, scans, radio, rewards and ends."""

from __future__ import annotations

import numpy as np
from numba import njit

from indoor_explorers.env.grid import FREE, MOVES, OCCUPIED, UNKNOWN
from indoor_explorers.env.lidar import Optics, Scan, new_scan, visible_cells
from indoor_explorers.env.radio import exchange, learn, link
from indoor_explorers.env.randomness import shuffled
from indoor_explorers.env.state import Rules, State

FLYING, GOAL, COLLISION, OUT_OF_BOUNDS, STUCK, BUDGET = 0, 1, 2, 3, 4, 5


@njit(cache=True, nogil=True, inline="always")
def sense(state: State, lens: Optics, b: int, agent: int, scan: Scan) -> None:
    """Scan from the agent's cell into its belief and the team's union."""
    truth, counts, union = state.truth[b].reshape(-1), state.counts[b].reshape(-1), state.union[b].reshape(-1)
    sensed, belief = state.sensed[b, agent].reshape(-1), state.belief[b, agent].reshape(-1)
    count = visible_cells(state.truth[b], state.cell[b, agent, 0], state.cell[b, agent, 1], lens, scan)
    state.visited[b, agent, state.cell[b, agent, 0], state.cell[b, agent, 1]] = True
    for k in range(count):
        cell = scan.cells[k]
        if sensed[cell]:
            continue
        sensed[cell] = True
        if counts[cell]:
            state.sensed_count[b, agent] += 1
        if belief[cell] == UNKNOWN:
            learn(state, b, agent, cell)
            state.discovered[b, agent] += 1
        if union[cell] == UNKNOWN:
            union[cell] = truth[cell]
            if counts[cell]:
                state.team_covered[b] += 1


@njit(cache=True, nogil=True, inline="always")
def _crash(rules: Rules, state: State, b: int, agent: int, end: int, pay: float) -> None:
    state.collisions[b, agent] += 1
    state.reward[b, agent] += pay
    if rules.end_on_collision:
        state.end[b, agent] = end


@njit(cache=True, nogil=True, inline="always")
def move(rules: Rules, state: State, b: int, agent: int, action: int) -> bool:
    """Carry out one agent's action; return whether it now is in another cell."""
    height, width = state.truth.shape[1:]
    if action == 4:
        return False
    row, col = state.cell[b, agent, 0] + MOVES[action, 0], state.cell[b, agent, 1] + MOVES[action, 1]
    if row < 0 or row >= height or col < 0 or col >= width:
        _crash(rules, state, b, agent, OUT_OF_BOUNDS, rules.pay_out_of_bounds)
        return False
    if state.truth[b, row, col] == OCCUPIED:
        _crash(rules, state, b, agent, COLLISION, rules.pay_collision)
        return False
    for mate in range(state.end.shape[1]):
        if (
            mate != agent
            and state.end[b, mate] == FLYING
            and state.cell[b, mate, 0] == row
            and state.cell[b, mate, 1] == col
        ):
            state.blocked[b, agent] += 1
            return False
    state.cell[b, agent, 0], state.cell[b, agent, 1] = row, col
    state.path_length[b, agent] += 1
    return True


@njit(cache=True, nogil=True, inline="always")
def _is_stuck(rules: Rules, state: State, b: int, agent: int) -> bool:
    if rules.stuck_rule == 1:
        return bool(state.idle[b, agent] >= state.truth.shape[1] * state.truth.shape[2])
    if rules.stuck_rule == 2:
        history = state.history[b, agent]
        for k in range(history.shape[0]):
            if history[k] >= 0 and np.sum(history == history[k]) >= rules.stuck_repeats:
                return True
    return False


@njit(cache=True, nogil=True, inline="always")
def _settle(rules: Rules, state: State, b: int) -> None:
    """Pay the flying agents for the step and end those that are done."""
    team_done = rules.goal_of_team and state.team_covered[b] >= state.needed[b]
    width = state.truth.shape[2]
    for n in range(state.end.shape[1]):
        if state.end[b, n] != FLYING:
            continue
        state.reward[b, n] += rules.pay_discovered * state.discovered[b, n] + rules.pay_received * state.received[b, n]
        state.idle[b, n] = 0 if state.discovered[b, n] + state.received[b, n] else state.idle[b, n] + 1
        state.history[b, n, state.step[b] % state.history.shape[2]] = state.cell[b, n, 0] * width + state.cell[b, n, 1]
        if team_done or (not rules.goal_of_team and state.covered[b, n] >= state.needed[b]):
            state.end[b, n] = GOAL
            state.reward[b, n] += rules.pay_goal
        elif _is_stuck(rules, state, b, n):
            state.end[b, n] = STUCK
            state.reward[b, n] += rules.pay_stuck
        elif state.step[b] >= state.budget[b]:
            state.end[b, n] = BUDGET


@njit(cache=True, nogil=True, inline="always")
def _update_legal(state: State, b: int, agent: int) -> None:
    height, width = state.truth.shape[1:]
    for action in range(4):
        row, col = state.cell[b, agent, 0] + MOVES[action, 0], state.cell[b, agent, 1] + MOVES[action, 1]
        inside = 0 <= row < height and 0 <= col < width
        state.legal[b, agent, action] = inside and state.truth[b, row, col] == FREE
    state.legal[b, agent, 4] = True


@njit(cache=True, nogil=True)
def begin(rules: Rules, state: State, lens: Optics, b: int) -> None:
    """Make the first scans and radio contacts of episode ``b``, whose truth and spawns are in place."""
    component = np.empty(state.end.shape[1], np.int64)
    scan = new_scan(lens)
    for n in range(state.end.shape[1]):
        sense(state, lens, b, n, scan)
        _update_legal(state, b, n)
    link(rules, state, b, component)
    exchange(state, b, component)


@njit(cache=True, nogil=True)
def advance(rules: Rules, state: State, lens: Optics, actions: np.ndarray) -> None:
    """Advance every episode with a flying agent by one step; ``actions`` is (B, N)."""
    team = state.end.shape[1]
    order, component = np.empty(team, np.int64), np.empty(team, np.int64)
    scan = new_scan(lens)
    for b in range(state.end.shape[0]):
        state.reward[b] = 0.0
        state.discovered[b] = 0
        state.received[b] = 0
        if np.all(state.end[b] != FLYING):
            continue
        shuffled(state.order_key[b], state.step[b], order)
        for k in range(team):
            n = order[k]
            if state.end[b, n] == FLYING:
                state.reward[b, n] += rules.pay_step
                if move(rules, state, b, n, actions[b, n]):
                    sense(state, lens, b, n, scan)
                    _update_legal(state, b, n)
        state.step[b] += 1
        link(rules, state, b, component)
        exchange(state, b, component)
        _settle(rules, state, b)
