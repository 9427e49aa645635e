"""Which teammates a decision takes into account, from what was last heard of them."""

from __future__ import annotations

from math import hypot, inf

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.policies.view import Briefing, Mate, Message, View
from indoor_explorers.env.scenarios.scenario import Radio

#: A teammate silent for longer is forgotten (Bautin 2012 keeps last-known positions for ever), in steps.
MEMORY = 60
#: A goal told by a teammate that has been silent for longer is ignored, in steps.
CLAIM_STEPS = 30


def certain_distance(radio: Radio, cell: Cell, mate: Mate) -> float:
    """Return how far away a teammate can be at most, by the radio's own measure.

    A teammate silent for some steps is within as many steps of where it was.
    """
    rows, cols = abs(cell[0] - mate.cell[0]), abs(cell[1] - mate.cell[1])
    away = max(rows, cols) if radio.model == "square" else hypot(rows, cols)
    return away + mate.age


def should_be_linked(radio: Radio, cell: Cell, mate: Mate) -> bool:
    """Tell whether a teammate, if it still flew, would have to be in contact.

    Where walls can be in the way or contacts can be lost, silence proves nothing.
    """
    if radio.loss > 0 or radio.model not in {"square", "disc", "unlimited"}:
        return False
    reach = inf if radio.model == "unlimited" else radio.range
    return certain_distance(radio, cell, mate) <= reach


def remembered(view: View, briefing: Briefing) -> list[Mate]:
    """Return the teammates to take into account: linked, or silent for a while but possibly still there.

    One that is silent although it would have to be in range has ended (IR2's rule).
    """
    radio = briefing.scenario.radio
    return [
        mate
        for mate in view.mates
        if mate.age == 0 or (mate.age <= MEMORY and not should_be_linked(radio, view.cell, mate))
    ]


def message_of(goal: Cell | None) -> Message:
    """Return what teammates should be told about a goal: its row and column."""
    return (float(goal[0]), float(goal[1])) if goal else None


def told_goal(mate: Mate) -> Cell | None:
    """Return the goal that a teammate told recently enough to count; None when there is none.

    A message's first two numbers are the goal, negative ones for none. Claims expire, so that a lost UAV does not keep
    its cells.
    """
    message = mate.message
    if message is None or len(message) < 2 or min(message[:2]) < 0 or mate.age > CLAIM_STEPS:
        return None
    return int(message[0]), int(message[1])


def claims(view: View, briefing: Briefing) -> NDArray[np.float64]:
    """Return the goals that remembered teammates have told lately, (M, 2) rows and columns."""
    told = [goal for mate in remembered(view, briefing) if (goal := told_goal(mate)) is not None]
    return np.array(told, np.float64).reshape(-1, 2)


def linked(view: View) -> list[Mate]:
    """Return the teammates that are linked now, directly or through others."""
    return [mate for mate in view.mates if mate.age == 0]


def whereabouts(mate: Mate) -> Cell:
    """Return the cell around which a teammate is taken to work: its goal while it counts, else where it was."""
    return told_goal(mate) or mate.cell
