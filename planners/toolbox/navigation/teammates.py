"""Which teammates a decision considers, by their last received messages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import hypot, inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.grid.levels import offset
from indoor_explorers.env.policies.view import Briefing, Mate, Message, View
from indoor_explorers.env.scenarios.parts import Radio

#: Steps of silence after which a teammate is forgotten (Bautin 2012 keeps last-known positions for ever).
MEMORY = 60
#: Steps of silence after which the goal in a teammate's last message is ignored.
CLAIM_STEPS = 30


def certain_distance(radio: Radio, cell: Cell, mate: Mate, rise: int) -> float:
    """Return the largest possible distance of a teammate, in the metric of the radio model.

    After n steps of silence it is at most n steps from its last received cell. ``rise`` is that of the map.
    """
    apart = [abs(axis) for axis in offset(*cell, *mate.cell, rise)]
    away = max(apart) if radio.model == "square" else hypot(*apart)
    return away + mate.age


def should_be_linked(radio: Radio, cell: Cell, mate: Mate, rise: int) -> bool:
    """Tell whether a teammate that still flies would certainly be in contact.

    Always False for radio models with walls or random loss, under which a flying teammate can be silent.
    """
    if radio.loss > 0 or radio.model not in {"square", "disc", "unlimited"}:
        return False
    reach = inf if radio.model == "unlimited" else radio.range
    return certain_distance(radio, cell, mate, rise) <= reach


def remembered(view: View, briefing: Briefing) -> list[Mate]:
    """Return the teammates to consider: linked ones, and silent ones that may still fly.

    A teammate that is silent although it would be in range has ended (IR2's rule).
    """
    radio, rise = briefing.scenario.radio, briefing.rise
    return [
        mate
        for mate in view.mates
        if mate.age == 0 or (mate.age <= MEMORY and not should_be_linked(radio, view.cell, mate, rise))
    ]


def message_of(goal: Cell | None) -> Message:
    """Return the message about a goal: its row and column."""
    return (float(goal[0]), float(goal[1])) if goal else None


def sent_goal(mate: Mate) -> Cell | None:
    """Return the goal in a teammate's message; None if it has none or the message is too old.

    A message's first two numbers are the goal, negative for none. Goals expire, so that a lost UAV does not keep
    claiming its cells.
    """
    message = mate.message
    if message is None or len(message) < 2 or min(message[:2]) < 0 or mate.age > CLAIM_STEPS:
        return None
    return int(message[0]), int(message[1])


def claims(view: View, briefing: Briefing) -> NDArray[np.float64]:
    """Return the recent goals of the remembered teammates, (M, 2) rows and columns."""
    sent = [goal for mate in remembered(view, briefing) if (goal := sent_goal(mate)) is not None]
    return np.array(sent, np.float64).reshape(-1, 2)


def linked(view: View) -> list[Mate]:
    """Return the teammates that are linked now, directly or through others."""
    return [mate for mate in view.mates if mate.age == 0]


def whereabouts(mate: Mate) -> Cell:
    """Return the cell around which a teammate probably works: its recent goal, else its last received cell."""
    return sent_goal(mate) or mate.cell


def ranks(own: NDArray[Any], others: Sequence[NDArray[Any]], first: Sequence[bool]) -> NDArray[np.int64]:
    """Return, for each of K candidates, how many UAVs rank before this one, (K,): the ranks of Bautin et al. 2012.

    ``own`` and each of ``others`` are (K,) distances in steps; ``first`` tells which of the others go
    first at equal distance. Unreachable candidates rank last.
    """
    rank = np.where(own < UNREACHABLE, 0, len(others) + 1)
    for steps, wins in zip(others, first, strict=True):
        rank += (steps <= own) if wins else (steps < own)
    return rank


class GroupMember(NamedTuple):
    """One UAV of a group, as the others know it."""

    agent: int
    cell: Cell
    goal: Cell | None


def group_of(own: GroupMember, mates: Iterable[Mate]) -> list[GroupMember]:
    """Return a UAV and its teammates, with their recent goals, by number."""
    return sorted([own, *(GroupMember(mate.agent, mate.cell, sent_goal(mate)) for mate in mates)])
