"""Failures and radio contacts of a step, compiled: the same rules for exact and for uncertain worlds.

The two kinds of worlds differ in the exchange of maps and in the removal of stopped UAVs' knowledge from the team's
map. Both functions are closed over, as numba cannot cache a function with function arguments.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

from indoor_explorers.env.grid.compiled import inner
from indoor_explorers.env.scenarios.codes import RadioModel
from indoor_explorers.env.simulation.engine import Work
from indoor_explorers.env.simulation.failures import silence_radios, stop_uavs
from indoor_explorers.env.simulation.home_base import link_base
from indoor_explorers.env.simulation.radio import link
from indoor_explorers.env.simulation.state import Rules, State

NO_RADIO = int(RadioModel.NONE)


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
