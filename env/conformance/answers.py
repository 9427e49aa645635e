"""Checks of what a policy answers: decisions, actions, messages, tallies."""

from __future__ import annotations

from indoor_explorers.env.conformance.harness import Subject
from indoor_explorers.env.policies.view import MESSAGE_LIMIT


def check_decisions(subject: Subject) -> str:
    """Demand that the policy decides at every step, raises nothing, and leaves views and briefings alone."""
    decisions = sum(len(trace.seconds) for trace in subject.alone)
    _demand(subject, "decisions")
    return f"{decisions} of one UAV and of four; nothing raised, views and briefing left alone"


def check_actions(subject: Subject) -> str:
    """Demand ints from 0 to 4, and count those that lead into a wall or off the map."""
    _demand(subject, "actions")
    into_walls = sum(trace.into_walls for trace in subject.alone)
    return f"all are ints from 0 to 4, {into_walls} of them into a wall or off the map"


def check_messages(subject: Subject) -> str:
    """Demand None or a few finite numbers."""
    _demand(subject, "messages")
    said = [choice.message for trace in subject.alone for step in trace.steps for choice in step.values()]
    longest = max((len(message) for message in said if message is not None), default=None)
    return "none said" if longest is None else f"finite numbers, at most {longest} in one ({MESSAGE_LIMIT} may be)"


def check_tally(subject: Subject) -> str:
    """Demand a dict of finite numbers after an episode."""
    _demand(subject, "tally")
    return "a dict of finite numbers, or nothing to tell"


def _demand(subject: Subject, kind: str) -> None:
    """Raise the first breach of a kind."""
    if (breach := subject.breach(kind)) is not None:
        raise breach
