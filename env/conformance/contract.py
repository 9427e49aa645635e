"""Check a policy's answers: the first violation of each kind is recorded, and a stay or no message replaces it."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from indoor_explorers.env.conformance.findings import CannotFly, Violation, calling, shown
from indoor_explorers.env.conformance.traces import Trace
from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.policies.policy import Pilot, checked_action
from indoor_explorers.env.policies.view import MESSAGE_LIMIT, Briefing, Message


def action_of(answer: object, trace: Trace, count: int = 5) -> int:
    """Return the action, or a stay for an answer that is none of ``count`` actions."""
    names = ", ".join([*(action.name.lower() for action in Action), "turn"][:count])
    try:
        return checked_action(answer, count, f" ({names})")
    except InputError as error:
        found = Violation(str(error), "return an int, such as int(np.argmax(values))")
        trace.violations.setdefault("actions", found)
        return int(Action.STAY)


def checked_message(said: Any, trace: Trace) -> Message:
    """Return the message, or None for an answer that is no message."""
    if said is None:
        return None
    if isinstance(said, tuple) and len(said) <= MESSAGE_LIMIT and all(map(_is_number, said)):
        return tuple(map(float, said))
    found = f"expected pilot.message to be None or a tuple of at most {MESSAGE_LIMIT} finite numbers, got {shown(said)}"
    fix = "write tuple(map(float, values)), and send the most important values if there are too many"
    trace.violations.setdefault("messages", Violation(found, fix))
    return None


def check_tallied(pilot: Pilot, trace: Trace) -> None:
    """Ask a pilot for its tally."""
    try:
        with calling("tally"):
            tally = pilot.tally()
    except CannotFly as error:
        trace.violations.setdefault("tally", error)
        return
    if not isinstance(tally, dict) or not all(isinstance(k, str) and _is_number(v) for k, v in tally.items()):
        found = f"expected tally to return a dict of finite numbers by name, got {shown(tally)}"
        trace.violations.setdefault("tally", Violation(found, "return {} to report nothing"))


def facts_of(briefing: Briefing) -> dict[str, str]:
    """Return the fields of a briefing as text, which later changes of the briefing do not affect."""
    names = ("agent", "team", "shape", "lidar_range", "scenario")
    with calling("the repr of the briefing"):
        return {name: repr(getattr(briefing, name, None)) for name in names}


def check_briefed(briefing: Briefing, facts: dict[str, str], trace: Trace) -> None:
    """Record a violation if a briefing differs from its fields at the start."""
    changed = [name for name, value in facts_of(briefing).items() if value != facts[name]]
    if changed:
        found = f"the briefing's {changed[0]} was changed"
        trace.violations.setdefault("decisions", Violation(found, "leave it as it is, and copy what you change"))


def _is_number(value: Any) -> bool:
    limit = sys.float_info.max
    return isinstance(value, (int, float, np.integer, np.floating)) and bool(-limit <= value <= limit)
