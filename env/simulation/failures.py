"""Failures: UAVs that stop, and temporary radio failures.

The team loses the cells that only a stopped UAV knew: coverage counts the knowledge of the base and of the UAVs that
did not stop. Draws depend on seed, step and UAV alone, so they are the same for all policies on one task.
"""

from __future__ import annotations

from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.grid.compiled import inner
from indoor_explorers.env.grid.randomness import uniform
from indoor_explorers.env.simulation.engine import ExactParts
from indoor_explorers.env.simulation.state import End, Rules, State

FLYING, STOPPED = int(End.FLYING), int(End.STOPPED)
#: The kinds of draws for each UAV in each step, and their number.
UAV, RADIO, KINDS = 0, 1, 2


@inner()
def _happens(state: State, b: int, agent: int, kind: int, hazard: float) -> bool:
    """Draw whether a failure of one kind happens to an agent in this step."""
    if hazard <= 0.0:
        return False
    return uniform(state.failure_key[b], (state.step[b] * state.end.shape[1] + agent) * KINDS + kind) < hazard


@inner()
def silence_radios(rules: Rules, state: State, b: int) -> None:
    """Let the radios that fail in this step be silent for the outage of the rules."""
    for n in range(state.end.shape[1]):
        silent = state.step[b] < state.silent_until[b, n]
        if not silent and _happens(state, b, n, RADIO, rules.radio_hazard):
            state.silent_until[b, n] = state.step[b] + rules.radio_outage


@inner()
def _stops(rules: Rules, state: State, b: int, agent: int) -> bool:
    """Stop an agent if it fails in this step; return whether it did."""
    listed = rules.stop_step[agent] == state.step[b]
    if state.end[b, agent] != FLYING or not (listed or _happens(state, b, agent, UAV, rules.hazard)):
        return False
    state.end[b, agent] = STOPPED
    state.reward[b, agent] += rules.reward_stopped
    return True


@inner()
def stop_uavs(rules: Rules, state: State, b: int) -> bool:
    """Stop the UAVs that fail in this step; return whether any did."""
    any_stopped = False
    for n in range(state.end.shape[1]):
        any_stopped |= _stops(rules, state, b, n)
    return any_stopped


@inner()
def forget_lost(parts: ExactParts, b: int) -> None:
    """Remove the cells that only stopped agents know from the team's union."""
    for n in range(parts.state.end.shape[1]):
        if parts.state.end[b, n] == STOPPED:
            _forget(parts.rules, parts.state, b, n)


@inner()
def _forget(rules: Rules, state: State, b: int, agent: int) -> None:
    """Remove the known cells of a stopped agent that neither the base nor a remaining agent knows from the union."""
    union, counts = state.union[b].flat, state.counts[b].flat
    for k in range(state.known[b, agent]):
        cell = state.discovery_log[b, agent, k]
        if union[cell] != UNKNOWN and not _is_held(rules, state, b, cell):
            union[cell] = UNKNOWN
            state.team_covered[b] -= counts[cell]


@inner()
def _is_held(rules: Rules, state: State, b: int, cell: int) -> bool:
    """Tell whether the base, or an agent that has not stopped, knows a flat cell."""
    if rules.base and state.base_belief[b].flat[cell] != UNKNOWN:
        return True
    for n in range(state.end.shape[1]):
        if state.end[b, n] != STOPPED and state.belief[b, n].flat[cell] != UNKNOWN:
            return True
    return False
