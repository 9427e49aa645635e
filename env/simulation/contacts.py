"""Failures and radio contacts of a step, compiled: the same rules for exact and for uncertain worlds.

The team loses the cells that only a stopped UAV knew: coverage counts the knowledge of the base and of the UAVs that
did not stop. Draws of failures depend on seed, step and UAV alone, so they are the same for all policies on one task.

The two kinds of worlds differ in the exchange of maps and in the removal of stopped UAVs' knowledge from the team's
map. Both functions are closed over, as numba cannot cache a function with function arguments.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.grid.compiled import inner
from indoor_explorers.env.grid.randomness import uniform
from indoor_explorers.env.scenarios.codes import RadioModel
from indoor_explorers.env.simulation.engine import ExactParts, Work
from indoor_explorers.env.simulation.home_base import link_base
from indoor_explorers.env.simulation.radio import link
from indoor_explorers.env.simulation.state import End, Rules, State

NO_RADIO, FLYING, STOPPED = int(RadioModel.NONE), int(End.FLYING), int(End.STOPPED)
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


class StepParts(Protocol):
    """The arguments of a step's compiled functions that all kinds of worlds share."""

    @property
    def rules(self) -> Rules:
        """The scenario's numbers."""

    @property
    def state(self) -> State:
        """The arrays of the batch."""

    @property
    def work(self) -> Work:
        """The working arrays of the thread."""


AnyParts = TypeVar("AnyParts", bound=StepParts)


def contacts_of(
    share_maps: Callable[[AnyParts, int, bool, bool], None], forget_lost: Callable[[AnyParts, int], None]
) -> tuple[Callable[[AnyParts, int], None], Callable[[AnyParts, int], None]]:
    """Return two compiled functions of (parts, episode) for one kind of world: ``contact`` and ``fail_and_contact``.

    Args:
        share_maps: Compiled; called as ``share_maps(parts, episode, linked, based)`` after contacts are known:
            whether any two agents are linked, and whether the base is in contact with any.
        forget_lost: Compiled; called as ``forget_lost(parts, episode)`` when UAVs stop.

    """

    @inner()
    def contact(parts: AnyParts, b: int) -> None:
        """Determine the contacts, and exchange maps."""
        rules, state, component = parts.rules, parts.state, parts.work.component
        linked = based = False
        if rules.base or (state.end.shape[1] > 1 and rules.radio_model != NO_RADIO):
            linked = link(rules, state, b, component)
            based = rules.base and link_base(rules, state, b, component)
        share_maps(parts, b, linked, based)

    @inner()
    def fail_and_contact(parts: AnyParts, b: int) -> None:
        """Apply the failures of a step and its contacts, in the order of the rules."""
        rules, state = parts.rules, parts.state
        if rules.failures:
            silence_radios(rules, state, b)
            if not rules.last_word and stop_uavs(rules, state, b):
                forget_lost(parts, b)
        contact(parts, b)
        if rules.failures and rules.last_word and stop_uavs(rules, state, b):
            forget_lost(parts, b)

    return contact, fail_and_contact
