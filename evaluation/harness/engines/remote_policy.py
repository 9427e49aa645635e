"""A policy whose pilots are in another process, so that the conformance checks are flown by this one."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, cast

from indoor_explorers.env import Briefing, Pilot, Policy, View
from indoor_explorers.env.errors import PolicyError
from indoor_explorers.env.simulation.rollout import Uav
from indoor_explorers.evaluation.harness.engines.policy_handle import PolicyHandle, ProcessEnded
from indoor_explorers.evaluation.harness.engines.process_handle import ProcessExit
from indoor_explorers.evaluation.harness.engines.remote_pilots import RemotePilots
from indoor_explorers.evaluation.harness.episodes.record import is_of_machine
from indoor_explorers.evaluation.harness.experiment.experiment import Job

#: Seconds that the last decision may take at least.
LEAST = 0.1


class RemotePolicy(Policy):
    """Stands for an isolated policy; fly one batch of episodes after the other.

    The process has some ``seconds`` for all that it is asked; one that takes longer is killed.
    """

    def __init__(self, process: PolicyHandle, job: Job, facts: Mapping[str, Any], seconds: float) -> None:
        """Have the policy of a job made there.

        Raises:
            InputError: it cannot be made.
            PolicyError: no time is left.
            ProcessEnded: its process ended, or had to be killed.

        """
        # variables of the class in other policies
        vars(self).update(uses_generator=facts["uses_generator"], map_shape=facts.get("map_shape"))
        self.seconds_left = seconds
        self.ended: ProcessExit | None = None
        """How its process ended or was killed; None while it runs."""
        self._process = process
        self._batch = _Batch()
        with self._timed():
            self._remote = RemotePilots(process, job)

    @classmethod
    def of(cls, process: PolicyHandle, job: Job, facts: Mapping[str, Any], seconds: float) -> RemotePolicy:
        """Return one that asks for many UAVs at once if the policy itself is asked so; see the constructor."""
        return (BatchedRemotePolicy if facts["batched"] else RemotePolicy)(process, job, facts, seconds)

    @property
    def killed(self) -> bool:
        """Whether the machine may have ended its process."""
        return self.ended is not None and is_of_machine(self.ended.reason)

    @property
    def unjudged(self) -> bool:
        """Whether it took too long, or the machine may have ended its process: what came after that tells nothing."""
        return self.seconds_left < 0 or self.killed

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV; the pilots of a batch are briefed together when the first of them is asked."""
        if self._batch.begun:
            self._batch = _Batch()
        return RemotePilot(self, self._batch.add(briefing))

    def decide(self, pilots: Sequence[Pilot], views: Sequence[View]) -> list[int]:
        """Return the actions of some UAVs of the batch.

        Raises:
            PolicyError: the policy failed there, or no time is left.
            ProcessEnded: its process ended, or had to be killed.

        """
        mine = cast(Sequence[RemotePilot], pilots)
        with self._timed():
            if not self._batch.begun:
                self._batch.begun = True
                for failure in self._remote.brief(self._batch.briefings).values():
                    raise PolicyError(failure)
            decided = self._remote.decide({pilot.uav: view for pilot, view in zip(mine, views, strict=True)})
        for failure in (decision.failure for decision in decided.values() if decision.failure):
            raise PolicyError(failure)
        for pilot in mine:
            pilot.message = decided[pilot.uav].message
        return [decided[pilot.uav].action for pilot in mine]

    @contextmanager
    def _timed(self) -> Iterator[None]:
        """Give the process the time that is left, and take the time of the block from it."""
        begun = time.monotonic()
        self._process.limits = self._process.limits._replace(decision_timeout=max(self.seconds_left, LEAST))
        try:
            yield
        except ProcessEnded as ended:
            self.ended = ended.how
            raise
        finally:
            self.seconds_left -= time.monotonic() - begun
        if self.seconds_left < 0:
            raise PolicyError("no time is left")


class BatchedRemotePolicy(RemotePolicy):
    """Asks for many UAVs at once."""

    batched = True

    def act(self, pilots: Sequence[Pilot], views: Sequence[View]) -> Sequence[int]:
        """Return the actions of some UAVs."""
        return self.decide(pilots, views)


class RemotePilot(Pilot):
    """Stands for a pilot in another process; ``uav`` is its place in the batch."""

    def __init__(self, policy: RemotePolicy, uav: Uav) -> None:
        self._policy, self.uav = policy, uav

    def act(self, view: View) -> int:
        """Ask there."""
        (action,) = self._policy.decide([self], [view])
        return action


class _Batch:
    """The briefings of a batch, which are given episode by episode, UAV by UAV."""

    def __init__(self) -> None:
        self.briefings: dict[int, list[Briefing]] = {}
        self.begun = False

    def add(self, briefing: Briefing) -> Uav:
        """Add a briefing; return the UAV that it is for."""
        episode = len(self.briefings) - (briefing.agent > 0)
        self.briefings.setdefault(episode, []).append(briefing)
        return episode, briefing.agent
