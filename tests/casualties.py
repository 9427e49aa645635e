"""Policies that lose a UAV: ``tests.casualties:pso`` is pso, of which UAV 0 flies into a wall soon after the start.

Fly them where a collision ends a UAV.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from indoor_explorers.env import Briefing, Message, Pilot, Policy, View, make_policy

#: The step from which on UAV 0 flies straight into the next wall.
STEP = 5


class Lost(Pilot):
    """Listen to another pilot up to a step, then to nobody."""

    def __init__(self, pilot: Pilot) -> None:
        self.pilot = pilot

    @property
    def message(self) -> Message:  # type: ignore[override]  # a pilot's message is an attribute; this one is passed on
        """What the other pilot says."""
        return self.pilot.message

    def act(self, view: View) -> int:
        """Fly into what is beside the UAV, or on until something is."""
        blocked = np.flatnonzero(~view.legal[:4])
        return int(blocked[0]) if len(blocked) else 0


@dataclass(frozen=True, kw_only=True)
class Casualty(Policy):
    """Fly the policy ``use``, and lose UAV 0."""

    use: str

    @cached_property
    def policy(self) -> Policy:
        return make_policy(self.use)

    def pilot(self, briefing: Briefing) -> Pilot:
        pilot = self.policy.pilot(briefing)
        return Lost(pilot) if briefing.agent == 0 else pilot

    def act(self, pilots: Sequence[Pilot], views: Sequence[View]) -> Sequence[int]:
        lost = [isinstance(pilot, Lost) and view.step >= STEP for pilot, view in zip(pilots, views, strict=True)]
        heard = [k for k, gone in enumerate(lost) if not gone]
        asked = [getattr(pilots[k], "pilot", pilots[k]) if isinstance(pilots[k], Lost) else pilots[k] for k in heard]
        chosen = dict(zip(heard, self.policy.act(asked, [views[k] for k in heard]), strict=True)) if heard else {}
        return [pilots[k].act(views[k]) if gone else chosen[k] for k, gone in enumerate(lost)]


class KnowingCasualty(Casualty):
    """The same of a policy that knows the map."""

    privileged = True


def __getattr__(name: str) -> Callable[[], Policy]:
    """Return what makes the policy ``name`` and loses a UAV of it."""
    if name.startswith("__"):
        raise AttributeError(name)
    return partial(KnowingCasualty if make_policy(name).privileged else Casualty, use=name)
