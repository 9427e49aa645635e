"""The common knowledge of a linked group: its members' goals, and the last received cells of absent teammates.

The members' memories differ, so a joint decision may only use the messages of all of them; a UAV uses its own last
message in the same way. A message is the goal (row, column), the plan that it is part of (step, first agent) and up to
four teammates out of contact: for each its number, the step when it was last heard, and its flat cell then.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.policies.view import MESSAGE_LIMIT, Briefing, Mate, Message, View
from indoor_explorers.planners.toolbox.navigation.teammates import MEMORY, linked, remembered, should_be_linked

#: Goal of a UAV without a goal in a message, and plan of a UAV without a plan.
NOWHERE = (-1.0, -1.0)
#: Numbers before the teammates out of contact.
_HEAD = 4


class LinkedMember(NamedTuple):
    """One UAV of the linked group."""

    agent: int
    cell: Cell
    goal: Cell | None
    plan: tuple[float, ...]
    """Step of its last joint plan, and lowest number in the group that made it."""
    absent: tuple[Mate, ...]
    """Teammates out of contact that it reported, with the age of their last message."""


def plan_message(view: View, briefing: Briefing, goal: Cell | None, plan: tuple[float, ...]) -> Message:
    """Return the message of a UAV after a decision."""
    away = sorted(
        (mate for mate in remembered(view, briefing) if mate.age > 0), key=lambda mate: (mate.age, mate.agent)
    )
    width = briefing.shape[1]
    facts = [(mate.agent, view.step - mate.age, mate.cell[0] * width + mate.cell[1]) for mate in away]
    head = (float(goal[0]), float(goal[1])) if goal else NOWHERE
    numbers = [float(number) for fact in facts[: (MESSAGE_LIMIT - _HEAD) // 3] for number in fact]
    return (*head, *plan, *numbers)


def _member(agent: int, cell: Cell, message: Message, view: View, width: int) -> LinkedMember:
    if message is None or len(message) < _HEAD:
        return LinkedMember(agent, cell, None, NOWHERE, ())
    numbers = [int(number) for number in message]
    goal = (numbers[0], numbers[1]) if numbers[0] >= 0 else None
    absent = [
        Mate(numbers[at], divmod(numbers[at + 2], width), view.step - numbers[at + 1], None)
        for at in range(_HEAD, len(numbers), 3)
    ]
    return LinkedMember(agent, cell, goal, message[2:_HEAD], tuple(absent))


def linked_members(view: View, briefing: Briefing, message: Message) -> list[LinkedMember]:
    """Return the members of the linked group by number, including this UAV with its own last ``message``."""
    known = [(mate.agent, mate.cell, mate.message) for mate in linked(view)]
    own = (briefing.agent, view.cell, message)
    return sorted(_member(*facts, view, briefing.shape[1]) for facts in [own, *known])


def absentees(members: Sequence[LinkedMember], briefing: Briefing) -> list[Mate]:
    """Return the teammates out of contact with the group, as last heard by any member, without forgotten ones."""
    radio, present = briefing.scenario.radio, {member.agent for member in members}
    latest: dict[int, Mate] = {}
    for mate in (mate for member in members for mate in member.absent):
        if mate.agent not in present and mate.age < latest.get(mate.agent, mate._replace(age=MEMORY + 1)).age:
            latest[mate.agent] = mate
    return [
        mate
        for _, mate in sorted(latest.items())
        if not any(should_be_linked(radio, member.cell, mate, briefing.rise) for member in members)
    ]
