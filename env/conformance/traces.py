"""The trace of a checked episode, and the checks of a policy's answers.

The trace records each UAV's decisions and the views they were based on, and the first violation of each kind; a stay or
no message replaces a wrong answer.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from indoor_explorers.env.conformance.findings import CannotFly, Violation, calling, shown
from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.grid.levels import action_names
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policies.explanation import Explanation
from indoor_explorers.env.policies.policy import Pilot, checked_action
from indoor_explorers.env.policies.view import MESSAGE_LIMIT, Briefing, Message, View, arrays_of, values_of


class Setup(NamedTuple):
    """Start of an episode: a seed, and a map, spawns and a prior map instead of those of the seed."""

    seed: int
    floorplan: Floorplan | None = None
    spawns: tuple[Cell, ...] | None = None
    prior: Belief | None = None


class Decision(NamedTuple):
    """A UAV's choice at one step, and a hash of its view."""

    view: bytes
    action: int
    message: Message

    @property
    def choice(self) -> tuple[int, Message]:
        """The policy's answer."""
        return self.action, self.message


#: The decisions of one step by UAV; UAVs that had ended or were not asked are missing.
Step = dict[int, Decision]


@dataclass
class Trace:
    """Record one episode."""

    setup: Setup
    steps: list[Step] = field(default_factory=list)
    unseen: list[bytes] = field(default_factory=list)
    """(H, W) bool at each step: cells that no UAV has seen."""
    seconds: list[float] = field(default_factory=list)
    """Time of each decision; in a batched act, each UAV's share."""
    into_walls: int = 0
    """Moves into a wall or off the map."""
    violations: dict[str, Violation] = field(default_factory=dict)
    """The first violation of each kind, named like the check that reports it."""


def digest_of(view: View) -> bytes:
    """Return a hash of a view."""
    seen = hashlib.blake2b(digest_size=16)
    for array in arrays_of(view):
        if array is not None:
            seen.update(array.tobytes())
    seen.update(repr(values_of(view)).encode())
    return seen.digest()


def first_difference(found: Trace, expected: Trace) -> int | None:
    """Return the first step at which two episodes differ in a decision; None when they are the same."""
    if found.steps == expected.steps:
        return None
    pairs = zip(found.steps, expected.steps, strict=False)
    shorter = min(len(found.steps), len(expected.steps))
    return next((step for step, (one, other) in enumerate(pairs) if one != other), shorter)


class TraceComparison(NamedTuple):
    """Result of comparing the decisions in two episodes of UAVs with the same views."""

    compared: int
    """Number of compared decisions: those of UAVs whose views were the same in both episodes so far."""
    differs: tuple[int, int] | None
    """(UAV, step) of the first different decision; None if all are the same."""


def compare(changed: Trace, recorded: Trace, agents: Sequence[int]) -> TraceComparison:
    """Compare the decisions of ``agents`` in two episodes.

    Each agent is compared until its own view differs for the first time, or it has ended in one of the episodes.
    """
    alike, compared = set(agents), 0
    for step, (now, then) in enumerate(zip(changed.steps, recorded.steps, strict=False)):
        alike = {n for n in alike if n in now and n in then and now[n].view == then[n].view}
        for n in sorted(alike):
            if now[n].choice != then[n].choice:
                return TraceComparison(compared, (n, step))
        compared += len(alike)
    return TraceComparison(compared, None)


def action_of(answer: object, trace: Trace, count: int = 5) -> int:
    """Return the action, or a stay for an answer that is none of ``count`` actions."""
    names = ", ".join(action_names(count))
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


def check_explained(told: object, shape: tuple[int, int]) -> None:
    """Raise a :class:`Violation` unless ``told`` explains an action on a map of this shape."""
    fix = "return None, or an Explanation of cells on the map and finite numbers"
    if not isinstance(told, Explanation):
        raise Violation(f"expected explain to return an Explanation or None, got {shown(told)}", fix)
    cells = [told.goal, *(each.cell for each in told.candidates), *told.path, *told.mates.values()]
    for cell in cells:
        if cell is not None and not all(0 <= at < side for at, side in zip(cell, shape, strict=True)):
            raise Violation(f"an explanation names the cell {cell}, which is not on the {shape} map", fix)
    for each in told.candidates:
        if not all(_is_number(value) for value in (each.score, *each.parts.values())):
            raise Violation(f"expected finite numbers in an explanation, got {shown(each)}", fix)


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
