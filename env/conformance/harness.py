"""A policy under test, and the flights that several checks share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

from indoor_explorers.env.conformance.findings import Violation, calling
from indoor_explorers.env.conformance.flying import Changed, CheckedFlight, together
from indoor_explorers.env.conformance.traces import Setup, Trace
from indoor_explorers.env.maps.sources import MapSource
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.scenarios.presets import PRESETS
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.rollout import Uav

#: Steps flown in each check.
STEPS = 60
#: One UAV and four in the thesis's 16x16 room, and four on a 64x64 map.
SOLO = PRESETS["thesis-obstacles"].for_evaluation()
TEAM = PRESETS["thesis-team-4"].for_evaluation()
LARGE = PRESETS["rooms"].for_evaluation().with_settings({"team": 4})
#: The starts of the episodes that most checks fly: the examined one, and one in the same batch.
FIRST, OTHER = Setup(11), Setup(12)


class Harness:
    """Fly a policy for the checks, and keep the flights that several of them need."""

    def __init__(self, policy: Policy) -> None:
        self.policy = policy
        self.pilot: type = Pilot
        """The class of its pilots; :class:`Pilot` before the first flight."""

    @property
    def batched(self) -> bool:
        """Whether the policy overrides ``act`` for many UAVs."""
        return type(self.policy).act is not Policy.act

    @cached_property
    def map_shape(self) -> tuple[int, int] | None:
        """The size of the only maps that the policy flies; None for any."""
        with calling("policy.map_shape"):
            return self.policy.map_shape

    def sized(self, scenario: Scenario) -> Scenario:
        """Return a scenario with maps of a size that the policy flies."""
        if self.map_shape is None:
            return scenario
        height, width = self.map_shape
        return scenario.with_settings({"map.height": height, "map.width": width})

    @cached_property
    def alone(self) -> tuple[Trace, Trace]:
        """The episodes of one UAV and of four, each in a batch of its own; the checks raise their violations."""
        solo = CheckedFlight(self.policy, self.sized(SOLO), [FIRST])
        self.pilot = solo.pilot_kind
        (one,) = solo.fly(STEPS)
        (team,) = CheckedFlight(self.policy, self.sized(TEAM), [FIRST]).fly(STEPS)
        return one, team

    @cached_property
    def beside(self) -> list[Trace]:
        """Two episodes of four UAVs, flown side by side."""
        return self.fly(TEAM, [FIRST, OTHER])

    def fly(
        self,
        scenario: Scenario,
        setups: Sequence[Setup],
        steps: int = STEPS,
        *,
        policy: Policy | None = None,
        ask: Callable[[list[Uav]], list[list[Uav]]] = together,
        changed: Changed | None = None,
        told: MapSource | None = None,
    ) -> list[Trace]:
        """Fly episodes side by side, with the policy or a copy of it; see ``CheckedFlight`` for the arguments.

        Raises:
            Violation: an answer breaks the contract, and none of the same kind did so in :attr:`alone`.

        """
        known, task = self.known_violations, self.sized(scenario)
        traces = CheckedFlight(policy or self.policy, task, setups, ask=ask, changed=changed, told=told).fly(steps)
        refuse_others(traces, known)
        return traces

    @property
    def known_violations(self) -> set[str]:
        """The kinds of violations in :attr:`alone`."""
        return {kind for trace in self.alone for kind in trace.violations}

    def violation(self, kind: str) -> Violation | None:
        """Return the first violation of a kind in :attr:`alone`."""
        return next((trace.violations[kind] for trace in self.alone if kind in trace.violations), None)


def refuse_others(traces: Sequence[Trace], known: set[str]) -> None:
    """Raise a violation of some episodes whose kind is not ``known``."""
    for trace in traces:
        for kind in trace.violations.keys() - known:
            raise trace.violations[kind]
