"""Checks of a policy's answers: decisions, actions, messages, tallies."""

from __future__ import annotations

from indoor_explorers.env.conformance.harness import Harness
from indoor_explorers.env.policies.view import MESSAGE_LIMIT


def check_decisions(harness: Harness) -> str:
    """Demand that the policy decides at every step, raises nothing, and leaves views and briefings alone."""
    decisions = sum(len(trace.seconds) for trace in harness.alone)
    _demand(harness, "decisions")
    return f"{decisions} of one UAV and of four; nothing raised, views and briefing left alone"


def check_actions(harness: Harness) -> str:
    """Demand ints from 0 to 4, and count those that lead into a wall or off the map."""
    _demand(harness, "actions")
    into_walls = sum(trace.into_walls for trace in harness.alone)
    return f"all are ints from 0 to 4, {into_walls} of them into a wall or off the map"


def check_messages(harness: Harness) -> str:
    """Demand None or a few finite numbers."""
    _demand(harness, "messages")
    said = [choice.message for trace in harness.alone for step in trace.steps for choice in step.values()]
    longest = max((len(message) for message in said if message is not None), default=None)
    return "none said" if longest is None else f"finite numbers, at most {longest} in one ({MESSAGE_LIMIT} may be)"


def check_tally(harness: Harness) -> str:
    """Demand a dict of finite numbers after an episode."""
    _demand(harness, "tally")
    return "a dict of finite numbers, or nothing to tell"


def _demand(harness: Harness, kind: str) -> None:
    """Raise the first violation of a kind."""
    if (violation := harness.violation(kind)) is not None:
        raise violation
