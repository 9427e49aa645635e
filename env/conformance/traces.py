"""The trace of a checked episode: each UAV's decisions and the views they were based on."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from indoor_explorers.env.conformance.findings import Violation
from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policies.view import Message, View, arrays_of, values_of


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
