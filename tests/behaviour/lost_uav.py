"""Policies that lose a UAV: ``tests.behaviour.lost_uav:pso`` is pso, but UAV 0 flies into a wall soon after the start.

Fly them where a collision ends a UAV.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from indoor_explorers.env import Briefing, Message, Pilot, Policy, View, make_policy

#: The step from which on UAV 0 flies straight into the next wall.
STEP = 5


class CrashingPilot(Pilot):
    """Acts as another pilot up to a step, then flies into a wall."""

    def __init__(self, pilot: Pilot) -> None:
        self.pilot = pilot

    @property
    def message(self) -> Message:  # type: ignore[override]  # a pilot's message is an attribute; this one is passed on
        """The message of the policy's own pilot."""
        return self.pilot.message

    def act(self, view: View) -> int:
        """Act as the policy's own pilot, then fly into what is beside the UAV, or on until something is."""
        if view.step < STEP:
            return self.pilot.act(view)
        blocked = np.flatnonzero(~view.legal[:4])
        return int(blocked[0]) if len(blocked) else 0


@dataclass(frozen=True, kw_only=True)
class LosesUav(Policy):
    """Fly the policy ``use``, and lose UAV 0."""

    use: str

    @cached_property
    def policy(self) -> Policy:
        return make_policy(self.use)

    def pilot(self, briefing: Briefing) -> Pilot:
        pilot = self.policy.pilot(briefing)
        return CrashingPilot(pilot) if briefing.agent == 0 else pilot


class PrivilegedLosesUav(LosesUav):
    """The same of a policy that knows the map."""

    privileged = True


@cache
def __getattr__(name: str) -> type[Policy]:
    """Return the class of policies that fly as ``name`` and lose a UAV."""
    if name.startswith("__"):
        raise AttributeError(name)
    base = PrivilegedLosesUav if make_policy(name).privileged else LosesUav
    body = {"__annotations__": {"use": str}, "use": name, "__module__": __name__}
    return dataclass(frozen=True, kw_only=True)(type(name, (base,), body))
