"""The step of the world, compiled: moves, scans, radio, rewards and ends."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.cells import OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.compiled import inner, kernel, leaf
from indoor_explorers.env.grid.levels import beside, degree, rise_of
from indoor_explorers.env.grid.randomness import shuffled
from indoor_explorers.env.scenarios.codes import RadioModel, StuckRule
from indoor_explorers.env.sensing.lidar import LidarModel, Scan, newly_visible_cells
from indoor_explorers.env.simulation.contacts import contacts_of, forget_lost
from indoor_explorers.env.simulation.engine import Engine, ExactParts, Work
from indoor_explorers.env.simulation.home_base import report
from indoor_explorers.env.simulation.radio import exchange, learn
from indoor_explorers.env.simulation.state import End, Rules, State

#: Plain numbers: comparing an array with an enumeration's member takes numpy ten times as long.
FLYING, GOAL, COLLISION, OUT_OF_BOUNDS, STUCK, BUDGET, _ = (int(end) for end in End)
NO_DISCOVERY, OSCILLATION = int(StuckRule.NO_DISCOVERY), int(StuckRule.OSCILLATION)
CUSTOM_RADIO = int(RadioModel.CUSTOM)


@inner()
def sense(state: State, lidar: LidarModel, b: int, agent: int, scan: Scan) -> None:
    """Scan from the agent's cell into its belief and the team's union; a revisited cell shows nothing new."""
    row, col = state.cell[b, agent, 0], state.cell[b, agent, 1]
    if state.visited[b, agent, row, col]:
        return
    sensed = state.sensed[b, agent].view(np.uint8)
    see(state, b, agent, scan.cells, newly_visible_cells(state.truth[b], sensed, row, col, lidar, scan))


@inner()
def see(state: State, b: int, agent: int, cells: np.ndarray, count: int) -> None:
    """Mark the first ``count`` of the flat ``cells`` (K,) as observed by an agent from where it is."""
    state.visited[b, agent, state.cell[b, agent, 0], state.cell[b, agent, 1]] = True
    sensed, belief, union = state.sensed[b, agent].flat, state.belief[b, agent].flat, state.union[b].flat
    truth, counts = state.truth[b].flat, state.counts[b].flat
    for k in range(count):
        cell = cells[k]
        if sensed[cell]:
            continue
        sensed[cell] = True
        state.sensed_count[b, agent] += counts[cell]
        if belief[cell] == UNKNOWN:
            learn(state, b, agent, cell)
            state.discovered[b, agent] += 1
        if union[cell] == UNKNOWN:
            union[cell] = truth[cell]
            state.team_covered[b] += counts[cell]


@inner()
def _crash(rules: Rules, state: State, b: int, agent: int, end: int, reward: float) -> bool:
    state.collisions[b, agent] += 1
    state.reward[b, agent] += reward
    if rules.end_on_collision:
        state.end[b, agent] = end
    return False


@inner()
def is_taken(state: State, b: int, row: int, col: int) -> bool:
    """Tell whether an agent flies in a cell."""
    for n in range(state.end.shape[1]):
        if state.cell[b, n, 0] == row and state.cell[b, n, 1] == col and state.end[b, n] == FLYING:
            return True
    return False


@inner()
def move(rules: Rules, state: State, b: int, agent: int, action: int) -> bool:
    """Carry out one agent's action; return whether it now is in another cell."""
    if action == 4:
        return False
    rise = rise_of(state.truth.shape[1], rules.levels)
    row, col = beside(state.cell[b, agent, 0], state.cell[b, agent, 1], action - (action > 4), rise)
    if row < 0 or row >= state.truth.shape[1] or col < 0 or col >= state.truth.shape[2]:
        return _crash(rules, state, b, agent, OUT_OF_BOUNDS, rules.reward_out_of_bounds)
    if state.truth[b, row, col] == OCCUPIED:
        return _crash(rules, state, b, agent, COLLISION, rules.reward_collision)
    if is_taken(state, b, row, col):
        state.blocked[b, agent] += 1
        return False
    state.cell[b, agent, 0], state.cell[b, agent, 1] = row, col
    state.path_length[b, agent] += 1
    return True


@inner()
def _is_stuck(rules: Rules, state: State, b: int, agent: int) -> bool:
    if rules.stuck_rule == NO_DISCOVERY:
        return bool(state.idle[b, agent] >= state.truth.shape[1] * state.truth.shape[2])
    if rules.stuck_rule == OSCILLATION:
        window, repeats = state.history.shape[2], 0
        here = state.history[b, agent, state.step[b] % window]
        for k in range(window):  # the cell it is in now is the only one whose count can have grown
            repeats += state.history[b, agent, k] == here
        return bool(repeats >= rules.stuck_repeats)
    return False


@inner()
def _all_know(state: State, b: int) -> bool:
    """Tell whether the own map of every flying agent has the coverage of the goal."""
    for n in range(state.end.shape[1]):
        if state.end[b, n] == FLYING and state.covered[b, n] < state.needed[b]:
            return False
    return True


@inner()
def finish_step(rules: Rules, state: State, b: int) -> None:
    """Compute the rewards of the flying agents, and end those that are done."""
    shared_goal = rules.goal_of_team or rules.goal_of_base or rules.goal_of_every
    team_done = (
        (rules.goal_of_team and state.team_covered[b] >= state.needed[b])
        or (rules.goal_of_base and state.base_covered[b] >= state.needed[b])
        or (rules.goal_of_every and _all_know(state, b))
    )
    width, window = state.truth.shape[2], state.history.shape[2]
    for n in range(state.end.shape[1]):
        if state.end[b, n] != FLYING:
            continue
        state.reward[b, n] += (
            rules.reward_discovered * state.discovered[b, n] + rules.reward_received * state.received[b, n]
        )
        state.idle[b, n] = 0 if state.discovered[b, n] + state.received[b, n] else state.idle[b, n] + 1
        state.history[b, n, state.step[b] % window] = state.cell[b, n, 0] * width + state.cell[b, n, 1]
        if team_done or (not shared_goal and state.covered[b, n] >= state.needed[b]):
            state.end[b, n] = GOAL
            state.reward[b, n] += rules.reward_goal
        elif _is_stuck(rules, state, b, n):
            state.end[b, n] = STUCK
            state.reward[b, n] += rules.reward_stuck
        elif state.step[b] >= state.budget[b]:
            state.end[b, n] = BUDGET


@inner()
def update_legal(rules: Rules, state: State, b: int, agent: int, occupancy: np.ndarray) -> None:
    """Set which moves from where an agent believes to be end neither off a map (H, W) nor in an obstacle of it."""
    (height, width), rise = occupancy.shape, rise_of(occupancy.shape[0], rules.levels)
    for k in range(degree(rise)):
        row, col = beside(state.believed_cell[b, agent, 0], state.believed_cell[b, agent, 1], k, rise)
        inside = 0 <= row < height and 0 <= col < width
        state.legal[b, agent, k + (k > 3)] = inside and occupancy[row, col] != OCCUPIED
    state.legal[b, agent, 4] = True


@inner()
def begin(rules: Rules, state: State, lidar: LidarModel, work: Work, b: int) -> None:
    """Make the first scans and radio contacts of episode ``b``, whose truth and spawns are in place.

    Those of plug-ins and of worlds with errors follow later, see :mod:`indoor_explorers.env.simulation.custom_models`
    and :mod:`indoor_explorers.env.simulation.slam`.
    """
    for n in range(state.end.shape[1]):
        if rules.exact_scans:
            sense(state, lidar, b, n, work.scan)
        update_legal(rules, state, b, n, state.truth[b])
    if rules.exact_scans and rules.radio_model != CUSTOM_RADIO:
        _contact(ExactParts(rules, state, work), b)


@inner()
def _share_beliefs(parts: ExactParts, b: int, linked: bool, based: bool) -> None:
    """Exchange what linked agents, and the base, know."""
    if linked or based:
        exchange(parts.state, b, parts.work.component, parts.work.before)
    if based:
        report(parts.state, b)


_contact, _fail_and_contact = contacts_of(_share_beliefs, forget_lost)


@inner()
def clear_step(state: State, b: int) -> bool:
    """Reset the rewards and counts of a step; return whether an agent of the episode flies."""
    flying = False
    for n in range(state.end.shape[1]):
        state.reward[b, n] = 0.0
        state.discovered[b, n] = 0
        state.received[b, n] = 0
        flying |= state.end[b, n] == FLYING
    return flying


@inner()
def _move_all(rules: Rules, state: State, lidar: LidarModel, work: Work, b: int, actions: np.ndarray) -> None:
    """Move the agents of an episode in their order of this step, each scanning where it arrives."""
    shuffled(state.order_key[b], state.step[b], work.order)
    for k in range(state.end.shape[1]):
        n = work.order[k]
        if state.end[b, n] == FLYING:
            state.reward[b, n] += rules.reward_step
            if move(rules, state, b, n, actions[b, n]):
                if rules.exact_scans:
                    sense(state, lidar, b, n, work.scan)
                update_legal(rules, state, b, n, state.truth[b])
    state.step[b] += 1


@inner()
def _contact_and_settle(rules: Rules, state: State, work: Work, b: int) -> None:
    """Apply failures, exchange maps, and end the step."""
    _fail_and_contact(ExactParts(rules, state, work), b)
    finish_step(rules, state, b)


@kernel()
def advance(engine: Engine, actions: np.ndarray, first: int, last: int) -> None:
    """Advance episodes first to last - 1 by one step where an agent flies; ``actions`` is (B, N)."""
    rules, state, lidar, work = engine.rules, engine.state, engine.lidar, engine.work
    for b in range(first, last):
        if clear_step(state, b):
            _move_all(rules, state, lidar, work, b, actions)
            _contact_and_settle(rules, state, work, b)


@kernel()
def begin_step(engine: Engine, actions: np.ndarray, flying: np.ndarray, first: int, last: int) -> None:
    """Do the first part of :func:`advance`, up to the scans; ``flying`` (B,) tells where an agent flew."""
    for b in range(first, last):
        flying[b] = clear_step(engine.state, b)
        if flying[b]:
            _move_all(engine.rules, engine.state, engine.lidar, engine.work, b, actions)


@kernel()
def enter_scan(engine: Engine, b: int, agent: int, cells: np.ndarray) -> None:
    """Enter the flat ``cells`` (K,) that an agent sees."""
    see(engine.state, b, agent, cells, cells.shape[0])


@kernel()
def end_step(engine: Engine, flying: np.ndarray, first: int, last: int) -> None:
    """Do the last part of :func:`advance`, from the radio contacts on, where ``flying`` (B,) says."""
    for b in range(first, last):
        if flying[b]:
            _contact_and_settle(engine.rules, engine.state, engine.work, b)


@kernel()
def first_contacts(engine: Engine, b: int) -> None:
    """Make the radio contacts of an episode that has just begun."""
    _contact(ExactParts(engine.rules, engine.state, engine.work), b)


@leaf()
def are_actions(actions: np.ndarray, count: int) -> bool:
    """Tell whether all of (B, N) numbers are in [0, count)."""
    good = True
    for action in actions.flat:
        good &= 0 <= action < count
    return good
